// The report of a robot in a real browser.
import assert from 'node:assert/strict';
import { readFileSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { openReport, settled, until } from './report.mjs';

/// The example with joints that are measured quickly; `csv` reads a table that a command wrote.
export async function robotReport({ browser, run, csv, work, pictures }) {
  run('robot', 'new', 'arm.toml');
  const file = join(work, 'arm.toml');
  writeFileSync(file, readFileSync(file, 'utf8').replace('ages = 7\n', 'ages = 3\npositions = 1\nte_positions = 64\n'));
  run('robot', 'arm.toml', '--out', 'arm', '--quiet', '--cache', 'cache');
  const report = join(work, 'arm', 'report.html');
  console.log(`report of the robot: ${(statSync(report).size / 1e6).toFixed(2)} MB`);
  assert.ok(statSync(report).size < 3e6);
  for (const [name, webgl, viewport, colorScheme] of [['wide', true, { width: 1200, height: 900 }, 'light'], ['phone', true, { width: 390, height: 800 }, 'dark'], ['flat', false, { width: 390, height: 800 }, 'dark']]) {
    const { page, context, complaints } = await openReport(browser, report, webgl, { viewport, colorScheme, reducedMotion: 'reduce', hasTouch: viewport.width < 500, acceptDownloads: true });
    const figure = page.locator('.figure.arm');
    await figure.scrollIntoViewIfNeeded();
    await figure.locator('canvas').first().waitFor();
    assert.equal(await figure.locator('.solid canvas').count(), webgl ? 1 : 0, `${name}: view in three dimensions`);
    assert.equal(await figure.locator('canvas.flat').count(), webgl ? 0 : 1, `${name}: flat drawing`);
    const picture = () => figure.locator('canvas').evaluate((canvas) => canvas.toDataURL());
    const change = async (what, action) => {
      const before = await picture();
      await action();
      await until(page, async () => await picture() !== before, `${name}: ${what}`);
      await settled(page, picture, `${name}: at rest after ${what}`);
    };
    const slider = (words) => figure.locator('label', { hasText: words }).locator('input');
    // With reduced motion the film waits for a click.
    assert.equal(await figure.getByRole('button', { name: 'Play' }).count(), 1);
    await settled(page, picture, `${name}: at rest`);
    await figure.screenshot({ path: join(pictures, `robot-${name}.png`) });
    await change('the time moves the arm', () => slider('Time').fill('2'));
    await change('the error is magnified', () => slider('Error').fill('3'));
    assert.ok((await figure.locator('label', { hasText: 'Error' }).innerText()).includes('× 1000'));
    await change('hours change the path', () => slider('Hours').fill('0'));
    await figure.locator('canvas').focus();
    await change('arrow keys turn the view', () => page.keyboard.press('ArrowLeft'));
    await change('another program has another path', () => figure.locator('label', { hasText: 'Program' }).locator('select').selectOption('1'));
    const standing = await picture();
    await figure.getByRole('button', { name: 'Play' }).click();
    await until(page, async () => await picture() !== standing, `${name}: the film runs`);
    await figure.getByRole('button', { name: 'Stop' }).click();
    await slider('Hours').fill('2');
    await change('shares of the moment have other colours', () => figure.locator('label', { hasText: 'Shares' }).locator('select').selectOption('now'));
    // Its way is that of path.csv, found there by the arm of the program and here by that of the page.
    const [download] = await Promise.all([page.waitForEvent('download'), figure.getByRole('button', { name: /CSV/ }).click()]);
    const [heads, ...rows] = readFileSync(await download.path(), 'utf8').trim().split('\n').map((row) => row.split(','));
    const [names, ...told] = csv('arm', 'path.csv');
    const at = (row, heading) => row[names.indexOf(heading)];
    const known = new Map(told.map((row) => [`${at(row, 'program')} ${Number(at(row, 'time_s')).toFixed(4)}`, row]));
    assert.equal(heads.length, 9);
    assert.equal(new Set(rows.map(([program]) => program)).size, 2);
    rows.forEach(([program, hours, time, x, y, z, ...off]) => {
      const row = known.get(`${program} ${Number(time).toFixed(4)}`);
      assert.ok(row, `${program} at ${time} s`);
      assert.equal(Number(hours), 20000);
      const apart = Math.hypot(x - at(row, 'x_mm'), y - at(row, 'y_mm'), z - at(row, 'z_mm'));
      assert.ok(apart < 0.1, `the way is ${apart} mm apart at ${time} s of ${program}`);
      ['error_x_mm', 'error_y_mm', 'error_z_mm'].forEach((key, i) => assert.ok(Math.abs(off[i] - at(row, key)) < 1e-4, `${key} at ${time} s`));
    });
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true, `${name}: nothing sticks out`);
    assert.deepEqual(complaints, []);
    await context.close();
  }
}
