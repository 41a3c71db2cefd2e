// A report in a real browser.

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
