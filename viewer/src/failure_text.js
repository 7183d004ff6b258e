// What failed, in the words of the report without those that only an asset's section explains.

/** Says the names of figures plainly. @param {string} words */
export const plain = (words) => words.replace(/(an? visible error of [0-9.e+-]+) \(p99\)/, "$1 at 99 % of the samples").replace("found rel_rms ", "found an RMS error of ")
  .replace(/^visible p99/, "visible error").replace(/^rel_rms/, "RMS error").replace(" with its dominant light", " of the whole shading");

/**
 * Returns the failures of an asset: what was found, where it is worst, and what to do. One piece of advice may stand for several limits: the last has it.
 * @param {string} name of the asset @param {{ subject: string, detail: string, advice?: string }[]} failures
 * @returns {{ found: string, worst: string | undefined, advice: string }[]}
 */
export const failureTexts = (name, failures) => failures.map(({ subject, detail, advice = "" }, at) => {
  const [found, worst] = detail.split("; worst at "), about = subject.slice(name.length).replace(/^, /, "").replace(/^stage total(, |$)/, "");
  return { found: `${about ? `${about}: ` : ""}${plain(found)}`, worst, advice: failures[at + 1]?.advice === advice ? "" : advice };
});
