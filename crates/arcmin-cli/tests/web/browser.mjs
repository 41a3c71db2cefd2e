// The explorer and figures of reports in a real browser: `node browser.mjs ARCMIN SCREENSHOTS`. Chromium is $CHROMIUM or the system's.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { chromium } from 'playwright-core';
import { openReport, until } from './report.mjs';
import { robotReport } from './robot.mjs';

const [arcmin, pictures] = process.argv.slice(2).map((path) => resolve(path));
mkdirSync(pictures, { recursive: true });
const executablePath = process.env.CHROMIUM || ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
const work = mkdtempSync(join(tmpdir(), 'arcmin-explore-'));
const run = (...words) => {
  try {
    execFileSync(arcmin, words, { cwd: work, stdio: 'pipe' });
  } catch (error) {
    // 1 says that the design has error findings.
    if (error.status !== 1) throw error;
  }
};
const servers = [];

function serve(design) {
  const server = spawn(arcmin, ['explore', design, '--no-browser'], { cwd: work, stdio: ['ignore', 'pipe', 'inherit'] });
  servers.push(server);
  return new Promise((done) => { server.stdout.once('data', (line) => done(String(line).trim())); });
}

const browser = await chromium.launch({ executablePath, args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'] });

async function open(address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, ...options });
  const page = await context.newPage();
  page.on('pageerror', (error) => { throw error; });
  const complaints = [];
  page.on('console', (message) => { if (message.type() === 'error') complaints.push(message.text()); });
  await page.goto(address);
  await page.waitForFunction(() => window.explorer && window.explorer.app.state);
  return { page, complaints };
}
const known = (page, name) => page.waitForFunction((n) => n in window.explorer.app.answers, name, { timeout: 240000 });
const figure = (page, name, key) => page.evaluate(([n, k]) => window.explorer.app.answers[n].summary[k], [name, key]);
const toml = (page) => page.evaluate(() => window.explorer.app.state.design.toml);

/// Numbers in the page are those of the command for the text that the page shows.
async function agrees(page, commands) {
  writeFileSync(join(work, 'changed.toml'), await toml(page));
  for (const [command, ...options] of commands) {
    run(command, 'changed.toml', '--out', 'told', '--force', '--quiet', ...options);
    const told = JSON.parse(readFileSync(join(work, 'told', 'summary.json')));
    await known(page, command);
    const own = await page.evaluate((name) => window.explorer.app.answers[name].summary, command);
    for (const [key, value] of Object.entries(own)) {
      // Bands, advice and the second judgement are left out by the explorer.
      if (command === 'life' && /verdict|band|advice|stages|hangs_on/.test(key)) continue;
      if (command === 'rig' && key === 'elastic_discs') continue;
      assert.deepEqual(value, told[key], `${command}: ${key}`);
    }
  }
}

async function change(page, key, value) {
  const input = page.locator(`[data-key="${key}"] input[type=number]`);
  await input.evaluate((control) => { control.closest('details').open = true; });
  await input.fill(String(value));
  await input.press('Tab');
  await page.waitForFunction(([k, v]) => window.explorer.app.state.design.values[k] === v, [key, value]);
}

/// A reply of the server that an undo has overtaken does not bring its design back.
async function lateReply(page) {
  const state = () => page.evaluate(() => window.explorer.app.state.state);
  const before = await state();
  let asked;
  let release;
  const isAsked = new Promise((done) => { asked = done; });
  const gate = new Promise((done) => { release = done; });
  await page.route('**/api/state?*', async (route) => {
    const response = await route.fetch();
    asked();
    await gate;
    await route.fulfill({ response });
  }, { times: 1 });
  // Another window sets a key, so that this page asks for the new state.
  await page.evaluate(async () => {
    const where = `/api/set?token=${new URLSearchParams(location.search).get('token')}`;
    const body = JSON.stringify({ key: 'load.rated_torque_n_m', value: 391, drag: false });
    await (await fetch(where, { method: 'POST', body })).json();
  });
  await isAsked;
  await page.evaluate(() => document.getElementById('undo').removeAttribute('disabled'));
  const undone = page.waitForResponse('**/api/undo?*');
  await page.locator('#undo').click();
  await (await undone).finished();
  const late = page.waitForResponse('**/api/state?*');
  release();
  await (await late).finished();
  await page.waitForTimeout(300);
  assert.equal(await state(), before, 'a late reply is dropped');
}

/// A drag is many requests, and its end is the value of the slider.
async function drag(page, key) {
  const slider = page.locator(`[data-key="${key}"] input[type=range]`);
  await slider.evaluate((control) => { control.closest('details').open = true; });
  await slider.focus();
  for (let i = 0; i < 5; i += 1) await slider.press('ArrowRight');
  const value = Number(await slider.inputValue());
  await page.waitForFunction(([k, v]) => window.explorer.app.state.design.values[k] === v, [key, value]);
  await slider.evaluate((control) => control.dispatchEvent(new Event('change')));
}

/// Rows of a table that a command wrote.
const csv = (...path) => readFileSync(join(work, ...path), 'utf8').trim().split('\n').map((row) => row.split(','));

/// The film has the rows of the tables of pins, ring by ring.
async function filmAgrees(page, design) {
  await page.waitForFunction(() => window.explorer.app.frames.length > 0);
  run('contact', design, '--out', 'film', '--quiet', '--force');
  const [film, keys] = await page.evaluate(() => [window.explorer.app.film.contacts, window.explorer.app.state.scene.rings.map((ring) => ring.key)]);
  keys.forEach((key, ring) => {
    const [head, ...rows] = csv('film', `${key}contact.csv`);
    const at = (name) => head.indexOf(name);
    assert.equal(film[ring].force_n.length, rows.length);
    rows.forEach((row, i) => assert.ok(Number(row[at('force_n')]) === film[ring].force_n[i] && Number(row[at('pin')]) === film[ring].pin[i], `row ${i} of ${key}contact.csv`));
  });
  // Rolling elements of eccentric bearings, where the family has them, or of turning-arm bearings.
  const [rollers, family] = await page.evaluate(() => [window.explorer.app.film.rollers, window.explorer.app.state.design.family]);
  const bearing = family === 'rv' ? 'turning_arm' : 'eccentric';
  if (family === 'rv') run('contact', design, '--joints', 'bearings', '--out', 'film', '--quiet', '--force');
  let lit = 0;
  keys.forEach((key, ring) => {
    const file = `${key}${bearing}_rollers.csv`;
    if (!existsSync(join(work, 'film', file))) { assert.equal(rollers[ring].force_n, null); return; }
    const [head, ...rows] = csv('film', file);
    assert.equal(rollers[ring].force_n.length, rows.length);
    for (const column of ['force_n', 'direction_deg', 'disc', 'crankshaft'].filter((name) => head.includes(name))) {
      rows.forEach((row, i) => assert.ok(Number(row[head.indexOf(column)]) === rollers[ring][column][i], `row ${i} of ${column} in ${file}`));
    }
    lit += rows.length;
  });
  return lit;
}

/// The report that the page opens is that of the command but for the command line in it.
async function reportAgrees(page, command) {
  const [opened] = await Promise.all([page.context().waitForEvent('page'), page.locator(`#results a[href*="/report/${command}/"]`).click()]);
  await opened.waitForSelector('#main', { timeout: 120000 });
  const [title, url] = [await opened.title(), opened.url()];
  assert.ok(title.startsWith(await page.evaluate(() => window.explorer.app.state.design.name)), title);
  const own = await page.evaluate(async (address) => (await fetch(address)).text(), url);
  writeFileSync(join(work, 'changed.toml'), await toml(page));
  const options = command === 'life' ? ['--discs', 'rigid'] : [];
  run(command, 'changed.toml', ...options, '--out', 'told', '--force', '--quiet');
  const typed = `${arcmin} ${command} changed.toml ${options.join(' ')} --out told --force --quiet`;
  const told = readFileSync(join(work, 'told', 'report.html'), 'utf8');
  const plain = (html) => html.replace(/arcmin \w+ (DESIGN( --discs rigid)?|changed\.toml( --discs rigid)? --out told --force --quiet)/g, 'COMMAND');
  assert.ok(plain(own) === plain(told), `report of ${typed}`);
  await opened.close();
}

/// A page saved beside the design works without its server.
async function saves(page, name) {
  await page.locator('#save').click();
  await page.locator('#save-what').selectOption('html');
  await page.locator('#save-do').click();
  await page.waitForFunction(() => document.getElementById('save-status').textContent.startsWith('saved'));
  const { size } = statSync(join(work, name));
  console.log(`saved page ${name}: ${(size / 1e6).toFixed(2)} MB`);
  assert.ok(size < 3e6);
  return open(`file://${join(work, name)}`);
}

try {
  run('new', 'rv-40e', 'rv.toml');
  run('new', 'tao2024', 'tao.toml');
  run('new', 'nema17-19', 'stage.toml');

  // An RV reducer: keys, undo, errors, compare, pictures.
  const rv = await open(await serve('rv.toml'));
  await known(rv.page, 'contact');
  await known(rv.page, 'check');
  await rv.page.waitForFunction(() => window.explorer.app.frames.length > 0);
  await rv.page.waitForSelector('[data-key="load.rated_torque_n_m"]');
  await rv.page.waitForTimeout(300);
  await rv.page.screenshot({ path: join(pictures, 'wide.png') });
  const first = await toml(rv.page);
  await agrees(rv.page, [['contact'], ['check']]);
  await rv.page.locator('#pin').click();
  await change(rv.page, 'disc.modification.equidistant_offset_um', 9);
  await agrees(rv.page, [['contact'], ['profile']]);
  await drag(rv.page, 'load.rated_torque_n_m');
  await agrees(rv.page, [['contact']]);
  await rv.page.screenshot({ path: join(pictures, 'compare.png') });
  assert.ok(await rv.page.locator('#results td.ghost').count() > 3, 'pinned figures are shown');
  await rv.page.locator('[data-key="load.rated_torque_n_m"] input[type=number]').fill('-1e9');
  await rv.page.locator('[data-key="load.rated_torque_n_m"] input[type=number]').press('Tab');
  await rv.page.waitForFunction(() => document.querySelector('[data-key="load.rated_torque_n_m"] .refused').textContent.length > 10);
  while (await rv.page.evaluate(() => window.explorer.app.state.can_undo)) {
    const before = await rv.page.evaluate(() => window.explorer.app.state.state);
    await rv.page.locator('#undo').click();
    await rv.page.waitForFunction((b) => window.explorer.app.state.state !== b, before);
  }
  assert.equal(await toml(rv.page), first, 'undo gives the same bytes');
  await lateReply(rv.page);
  assert.ok(await filmAgrees(rv.page, 'rv.toml') > 1000, 'rolling elements of the turning arms');
  // Keyboard: turn the view and the crank.
  const picture = () => rv.page.evaluate(() => document.getElementById('canvas').toDataURL());
  await rv.page.locator('#canvas').focus();
  const still = await picture();
  for (const key of ['ArrowLeft', 'ArrowUp', '+']) await rv.page.keyboard.press(key);
  await until(rv.page, async () => await picture() !== still, 'arrow keys turn the view');
  await rv.page.locator('#crank').focus();
  await rv.page.keyboard.press('ArrowRight');
  assert.equal(await rv.page.evaluate(() => window.explorer.app.crank), 1);
  await rv.page.locator('#explode').fill('60');
  await rv.page.locator('#cut').selectOption('none');
  await rv.page.waitForTimeout(200);
  await rv.page.screenshot({ path: join(pictures, 'explode.png') });
  // Frames a second of the film.
  await rv.page.setViewportSize({ width: 900 + 460, height: 900 });
  const rate = await rv.page.evaluate(async () => {
    const { view } = window.explorer;
    document.getElementById('run').click();
    const [before, since] = [view.frames, performance.now()];
    await new Promise((done) => { setTimeout(done, 2000); });
    document.getElementById('run').click();
    return (1000 * (view.frames - before)) / (performance.now() - since);
  });
  console.log(`film: ${rate.toFixed(1)} frames a second`);
  assert.deepEqual(rv.complaints.filter((text) => !/422/.test(text)), []);
  const missing = await rv.page.evaluate(() => Promise.all(['film/0', 'contact/99999', 'contact/x', 'contact/0/0'].map(async (path) => {
    const token = new URLSearchParams(location.search).get('token');
    return (await fetch(`/api/report/${path}?token=${token}`)).status;
  })));
  assert.deepEqual(missing, [404, 404, 404, 404]);
  const times = await rv.page.evaluate(async () => {
    const token = new URLSearchParams(location.search).get('token');
    const all = [];
    for (let i = 0; i < 12; i += 1) {
      const since = performance.now();
      const body = JSON.stringify({ key: 'load.rated_torque_n_m', value: 380 + i, drag: true });
      await (await fetch(`/api/set?token=${token}`, { method: 'POST', body })).json();
      all.push(performance.now() - since);
    }
    return all.sort((a, b) => a - b);
  });
  console.log(`drag: median ${times[6].toFixed(0)} ms, largest ${times[11].toFixed(0)} ms`);

  // A single stage on a phone, in the dark, without motion.
  const phone = await open(await serve('stage.toml'), { viewport: { width: 400, height: 800 }, colorScheme: 'dark', reducedMotion: 'reduce', hasTouch: true });
  await known(phone.page, 'check');
  await known(phone.page, 'life');
  await phone.page.waitForFunction(() => window.explorer.app.frames.length > 0);
  await phone.page.waitForSelector('[data-key="disc.width_mm"]');
  await known(phone.page, 'rig');
  await agrees(phone.page, [['contact'], ['check'], ['rig'], ['life', '--discs', 'rigid']]);
  await phone.page.waitForFunction(() => window.explorer.app.answers.advice);
  const without = await phone.page.evaluate(() => [...document.querySelectorAll('#results td.words')].map((cell) => cell.textContent));
  assert.deepEqual(without, ['not for single stages'], 'answers that a family does not have say so');
  assert.equal(await phone.page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true, 'nothing sticks out on a phone');
  assert.equal(await phone.page.locator('#run').textContent(), 'Step');
  await phone.page.locator('#hours').fill('7');
  await phone.page.waitForFunction(() => window.explorer.app.age === 7);
  await phone.page.screenshot({ path: join(pictures, 'phone-dark.png'), fullPage: true });
  for (const command of ['contact', 'rig', 'life']) await reportAgrees(phone.page, command);
  const [view, keys] = await phone.page.evaluate(() => ['.view', '#keys'].map((one) => document.querySelector(one).getBoundingClientRect().top));
  assert.ok(keys > view, 'controls stand below the view');
  await change(phone.page, 'output_pins.count', 5);
  await agrees(phone.page, [['contact']]);

  // Drives of two rings and of two stages: keys of either, film, pictures, the page without its server.
  for (const [template, key] of [['two-ring-225', 'second_disc.modification.equidistant_offset_um'], ['two-stage-500', 'first_stage.disc.modification.equidistant_offset_um']]) {
    run('new', template, `${template}.toml`);
    const { page, complaints } = await open(await serve(`${template}.toml`));
    await page.waitForSelector(`[data-key="${key}"]`);
    assert.ok(await filmAgrees(page, `${template}.toml`) > 100);
    const lit = await page.evaluate(() => window.explorer.view.bodies.filter(({ body, instanced }) => body.kind === 'rollers' && instanced).map(({ instanced }) => new Set(instanced.instanceColor.array).size));
    assert.ok(lit.length >= 1 && lit.every((tones) => tones > 3), `loaded rolling elements are lit: ${lit}`);
    await page.screenshot({ path: join(pictures, `${template}.png`) });
    await drag(page, key);
    await drag(page, 'load.rated_torque_n_m');
    await agrees(page, [['profile'], ['contact'], ['check'], ['rig'], ['life', '--discs', 'rigid']]);
    for (const command of ['contact', 'life']) await reportAgrees(page, command);
    await page.locator('#hours').fill('9');
    await page.waitForFunction(() => window.explorer.app.age === 9);
    const worn = await page.evaluate(() => window.explorer.view.state.wear.map((depths) => Math.max(...depths)));
    assert.ok(worn.length === 2 && worn.every((depth) => depth > 0), `worn flanks of both rings: ${worn}`);
    await page.screenshot({ path: join(pictures, `${template}-worn.png`) });
    await page.locator('#crank').fill('200');
    await page.locator('#cut').selectOption('none');
    await page.locator('#explode').fill('60');
    await page.waitForTimeout(200);
    await page.screenshot({ path: join(pictures, `${template}-explode.png`) });
    const picked = await page.evaluate(() => {
      const { app, view } = window.explorer;
      const pressed = view.bodies.filter((b) => b.instanced).map((b) => b.body.ring);
      return { rings: app.state.scene.rings.length, pressed: new Set(pressed).size, drawn: new Set(app.frame.contacts.map((c) => c.ring)).size };
    });
    assert.deepEqual(picked, { rings: 2, pressed: 2, drawn: 2 });
    const offline = await saves(page, `${template}.html`);
    await offline.page.locator('#crank').fill('90');
    await offline.page.waitForFunction(() => window.explorer.app.frame.contacts.length > 0);
    await offline.page.locator('#hours').fill('9');
    await offline.page.waitForFunction(() => window.explorer.app.frame.contacts.length > 0 && window.explorer.app.age === 9);
    assert.deepEqual([...complaints, ...offline.complaints], []);
    await page.context().close();
  }

  // The hours of the paper's machine, and the page without its server.
  const tao = await open(await serve('tao.toml'));
  await known(tao.page, 'life');
  await known(tao.page, 'rig');
  run('life', 'tao.toml', '--quasi-static', '--bodies', 'rigid', '--out', 'life', '--quiet');
  // Keys of the advice come first, with its sentences.
  await known(tao.page, 'advice');
  const { advice, advice_keys: advised } = JSON.parse(readFileSync(join(work, 'life', 'summary.json'), 'utf8'));
  assert.ok(advised.length > 0 && advice.length === advised.length);
  const front = await tao.page.evaluate(() => [...document.querySelectorAll('#keys .key')].map((row) => [row.dataset.key, row.querySelector('.advised').textContent]));
  assert.deepEqual(front.slice(0, advised.length), advised.map((key, i) => [key, advice[i]]));
  assert.ok(front.slice(advised.length).every(([, text]) => text === ''));
  const [columns, ...ages] = csv('life', 'life.csv');
  for (const index of [0, 7, ages.length - 1]) {
    await tao.page.locator('#hours').fill(String(index));
    await tao.page.waitForFunction((i) => window.explorer.app.age === i, index);
    const cells = await tao.page.evaluate(() => Object.fromEntries([...document.querySelectorAll('[data-age]')].map((row) => [row.dataset.age, row.querySelector('td').dataset.value])));
    columns.forEach((column, i) => { if (column in cells) assert.equal(Number(cells[column]), Number(ages[index][i]), `${column} at ${ages[index][0]} h`); });
    assert.ok(Object.keys(cells).length > 8);
  }
  await agrees(tao.page, [['life', '--quasi-static', '--bodies', 'rigid']]);
  await tao.page.screenshot({ path: join(pictures, 'hours.png') });
  const offline = await saves(tao.page, 'tao.html');
  servers.forEach((server) => server.kill());
  assert.ok(await offline.page.locator('[data-key] input').first().isDisabled());
  await offline.page.locator('#hours').fill('20');
  assert.equal(await offline.page.evaluate(() => window.explorer.app.age), 20);
  await offline.page.locator('#crank').fill('90');
  assert.equal(await offline.page.evaluate(() => window.explorer.app.crank), 90);
  await offline.page.waitForTimeout(200);
  await offline.page.screenshot({ path: join(pictures, 'offline.png') });
  assert.deepEqual(offline.complaints, []);

  // The report of the life has the view in it, and the drawing where there is no WebGL.
  const report = join(work, 'life', 'report.html');
  console.log(`report of the life: ${(statSync(report).size / 1e6).toFixed(2)} MB`);
  assert.ok(statSync(report).size < 3e6);
  for (const webgl of [true, false]) {
    const { page, context, complaints } = await openReport(browser, report, webgl, { viewport: { width: webgl ? 1200 : 400, height: 900 }, colorScheme: webgl ? 'light' : 'dark' });
    const figure = page.locator('.figure.solids');
    await figure.scrollIntoViewIfNeeded();
    await figure.locator(webgl ? 'canvas' : 'svg.drawing').first().waitFor();
    assert.equal(await figure.locator('canvas').count(), webgl ? 1 : 0);
    assert.equal(await figure.locator('svg.drawing').count(), webgl ? 0 : 1);
    await figure.screenshot({ path: join(pictures, `report-${webgl ? 'solids' : 'drawing'}.png`) });
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true, 'nothing sticks out of the report');
    assert.deepEqual(complaints, []);
    await context.close();
  }
  await robotReport({ browser, run, csv, work, pictures });
  console.log('explorer and reports: sound');
} finally {
  servers.forEach((server) => server.kill());
  await browser.close();
  rmSync(work, { recursive: true, force: true });
}
