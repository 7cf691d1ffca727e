// SPDX-License-Identifier: GPL-3.0-or-later
// run_wasm.mjs PROGRAM.wasm [ARGUMENT]...: runs a WASI program in Node. It sees its arguments and the variables that
// start with DGM_ or GTEST_, and no files.
import { readFile } from 'node:fs/promises';
import { env, exit } from 'node:process';
import { WASI } from 'node:wasi';

const args = process.argv.slice(2);
const shown = Object.fromEntries(Object.entries(env).filter(([name]) => /^(DGM|GTEST)_/.test(name)));
const wasi = new WASI({ version: 'preview1', args, env: shown, returnOnExit: true });
const module = await WebAssembly.compile(await readFile(args[0]));
exit(wasi.start(await WebAssembly.instantiate(module, wasi.getImportObject())));
