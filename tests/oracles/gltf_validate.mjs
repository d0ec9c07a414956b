#!/usr/bin/env node
// Check a .glb or .gltf with the real Khronos glTF validator (npm `gltf-validator`).
//
//   node gltf_validate.mjs FILE [--full]
//
// stdout: one JSON object: error/warning/info/hint counts, messages, and what the file holds.
// exit:   0 no errors; 1 errors or did not load; 2 bad usage.   --full keeps the validator's whole report.
// The package is looked for in $GLTF_VALIDATOR_DIR, then $LOFTSMAN_ORACLES/node, then the usual places.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";

function loadValidator() {
  for (const base of [process.env.GLTF_VALIDATOR_DIR, process.env.LOFTSMAN_ORACLES && `${process.env.LOFTSMAN_ORACLES}/node`, process.cwd()]) {
    if (!base) continue;
    try {
      return createRequire(join(base, "package.json"))("gltf-validator");
    } catch (problem) {
      if (problem.code !== "MODULE_NOT_FOUND") throw problem;
    }
  }
  throw new Error("gltf-validator is not installed: npm install --prefix $LOFTSMAN_ORACLES/node gltf-validator");
}

const severities = ["error", "warning", "info", "hint"];
const args = process.argv.slice(2);
const file = args.find((a) => !a.startsWith("--"));
if (!file) {
  console.error("usage: node gltf_validate.mjs FILE [--full]");
  process.exit(2);
}
const report = { tool: "Khronos glTF validator", file };
try {
  const validator = loadValidator();
  report.tool += " " + validator.version();
  const full = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: file,
    maxIssues: 0,
    writeTimestamp: false,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(resolve(dirname(file), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, numInfos, numHints, messages } = full.issues;
  Object.assign(report, { errors: numErrors, warnings: numWarnings, infos: numInfos, hints: numHints });
  report.messages = messages.map((m) => ({ ...m, severity: severities[m.severity] }));
  report.info = full.info;
  if (args.includes("--full")) report.full = full;
} catch (problem) {
  report.error = String(problem);
}
process.stdout.write(JSON.stringify(report, null, 1) + "\n", () => {
  process.exitCode = report.error || report.errors > 0 ? 1 : 0;
});
