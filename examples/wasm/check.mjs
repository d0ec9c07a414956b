// The module's answers beside the closed form: the least d with Σ Nᵢ dᵢ = b is dᵢ = Nᵢ b / Σ Nⱼ².
import { readFileSync } from 'node:fs';

const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]), {});
const { rise } = instance.exports;
const bernstein = (u) => [(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u * u * (1 - u), u ** 3];

let checked = 0;
for (const at of [0, 0.1, 0.5, 0.75, 1]) {
  const n = bernstein(at);
  const squares = n.reduce((sum, x) => sum + x * x, 0);
  for (const by of [1, -0.25, 1e6]) {
    n.forEach((x, vertex) => {
      const [ours, theirs] = [rise(vertex, at, by), (x * by) / squares];
      if (!(Math.abs(ours - theirs) <= 1e-14 * Math.abs(by))) throw new Error(`at ${at} by ${by}: ${ours}, not ${theirs}`);
      checked += 1;
    });
  }
}
for (const [at, by] of [[2, 1], [NaN, 1], [0.5, Infinity]])
  if (!Number.isNaN(rise(0, at, by))) throw new Error(`at ${at} by ${by} is not refused`);
console.log(`wasm: ${checked} vertices where the closed form has them, what cannot be asked is refused`);
