// Writes three.min.js from entry.js: `npm install --no-save three@0.187 esbuild && node build.mjs`, in this directory.
import { build } from 'esbuild';

await build({
  entryPoints: ['entry.js'], bundle: true, minify: true, format: 'iife', globalName: 'THREE', legalComments: 'inline',
  target: 'es2020', outfile: 'three.min.js',
});
