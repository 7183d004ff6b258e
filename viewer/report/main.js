// The page of a report: report.html. Its data, a report of one scene or of several, stand in the element "data"; pipeline/report/page.h says what they hold.
// The table that the program wrote for readers without scripts stays if the page cannot be built.
import { byId } from "../src/elements.js";
import { collectionPage } from "./compare.js";
import { formats, kinds } from "./parts.js";
import { pictures } from "./pictures.js";
import { scenePage } from "./scene.js";
import { addTools } from "./tools.js";

const data = JSON.parse(byId("data").textContent ?? "");
Object.assign(kinds, data.kinds);
Object.assign(formats, data.formats);
Object.assign(pictures, data.pictures);
const sections = /** @type {any[]} */ (data.collection ? collectionPage(data) : scenePage(data)).flat().filter((section) => section);
document.querySelector("main")?.replaceChildren(...sections);
addTools();
