// The hours of a life: its table and figures, and the depth of the flanks at an age. Called by app.js, which has `app`.
function lifeTable() {
  const life = app.answers.life;
  if (life && life.table) return life.table;
  if (app.reached.length === 0) return null;
  return { hours: app.reached.map((p) => p.hours), max_depth_um: app.reached.map((p) => p.max_depth_um) };
}

function depthsAt(index) {
  const life = app.answers.life;
  if (life && life.ages) return life.ages.depth_um[index] || null;
  return app.reached[index] ? app.reached[index].depth_um : null;
}

function forcesAt(hours) {
  const life = app.answers.life;
  if (!life || !life.ages || life.ages.forces.length === 0) return null;
  return life.ages.forces.reduce((best, one) => (Math.abs(one.hours - hours) < Math.abs(best.hours - hours) ? one : best));
}

function showHours() {
  const table = lifeTable();
  const life = app.answers.life;
  const slider = $('hours');
  const status = $('life-status');
  if (life && life.status !== 'done') status.textContent = [life.error, life.hint].filter(Boolean).join('; ');
  else if (life) {
    const verdict = life.summary.verdict || {};
    status.textContent = `${life.command}: ${verdict.ok ? 'all limits are kept' : `limited by ${String(verdict.limited_by || 'a limit').replace(/_/g, ' ')}`}, first limit after ${shown(life.summary.hours_to_limit)} h`;
  } else status.textContent = app.reached.length > 0 ? `wear up to ${shown(app.reached[app.reached.length - 1].hours)} h, going on …` : 'life is being computed …';
  slider.parentElement.hidden = Boolean(life && life.status === 'not_available');
  const rows = table ? table.hours.length : 0;
  slider.disabled = rows < 2;
  slider.max = Math.max(rows - 1, 0);
  app.age = Math.min(app.age, Math.max(rows - 1, 0));
  slider.value = app.age;
  const hours = table ? table.hours[app.age] : 0;
  $('hours-value').textContent = hours > 0 ? `${shown(hours, 5)} h` : 'new';
  const pinned = app.pinned && app.pinned.table;
  drawStrip($('strip'), table, pinned, app.state.design.limits, app.state.design.limits.service_life_h, hours);
  const cells = [];
  if (life && life.table) {
    for (const [key, column] of Object.entries(life.table)) {
      if (key === 'hours' || column[app.age] === null) continue;
      const { words, unit } = labelOf(key);
      cells.push(element('tr', { 'data-age': key }, element('th', { scope: 'row', title: key }, words), element('td', { 'data-value': column[app.age] }, `${shown(column[app.age], 5)} ${unit}`)));
    }
  }
  $('age').replaceChildren(element('tbody', {}, ...cells));
  showFrame();
}
