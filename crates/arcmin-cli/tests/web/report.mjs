// A report in a real browser.
import assert from 'node:assert/strict';

/// Opens a report, with WebGL or in a browser without it. `complaints` collects errors, and requests, of which a report makes
/// none.
export async function openReport(browser, report, webgl, options) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('console', (message) => { if (message.type() === 'error') complaints.push(message.text()); });
  page.on('request', (request) => { if (/^https?:/.test(request.url())) complaints.push(request.url()); });
  if (!webgl) {
    await page.addInitScript(() => {
      const own = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function without(kind, ...others) { return /webgl/.test(kind) ? null : own.call(this, kind, ...others); };
    });
  }
  await page.goto(`file://${report}`);
  return { page, context, complaints };
}

/// Waits until `condition` holds; machines that draw slowly get time for it.
export async function until(page, condition, what, milliseconds = 20000) {
  const end = Date.now() + milliseconds;
  while (!await condition()) {
    assert.ok(Date.now() < end, what);
    await page.waitForTimeout(100);
  }
}

/// Waits until `picture` stays the same for half a second: everything that was asked for is drawn, and nothing moves by itself.
export async function settled(page, picture, what) {
  let last = await picture();
  await until(page, async () => {
    await page.waitForTimeout(400);
    const before = last;
    last = await picture();
    return last === before;
  }, what);
}
