export * from "./three.js";
