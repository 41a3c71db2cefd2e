// A triangle mesh, its deformed shape and a field on it, on a canvas because there are thousands of triangles.

class MeshFigure {
  constructor(figure, mesh) {
    this.figure = figure;
    this.mesh = mesh;
    this.stage = figure.querySelector('.stage');
    this.stage.textContent = '';
    const row = htmlElement('div', { class: 'row' }, this.stage);
    this.canvas = htmlElement('canvas', { role: 'img', 'aria-label': `${mesh.title}: ${mesh.nodes_mm.length / 2} nodes, ${mesh.triangles.length} triangles` }, this.stage);
    this.moved = mesh.displacement_um.length === mesh.nodes_mm.length;
    this.extent = bounds(mesh.nodes_mm);
    const largest = this.moved ? Math.max(1e-12, ...mesh.displacement_um.map(Math.abs)) : 1;
    // Deformation is shown at about a twentieth of the size unless the reader changes the factor.
    this.full = this.extent.size * 0.05 / (largest * 1e-3);
    this.part = this.moved ? 0.5 : 0;
    if (this.moved) {
      const label = htmlElement('label', {}, row, 'Deformation '), slider = htmlElement('input', { type: 'range', min: 0, max: 1, step: 0.01, value: this.part, 'aria-label': 'Exaggeration of the deformation' }, label);
      this.readout = htmlElement('output', {}, row);
      slider.addEventListener('input', () => { this.part = Number(slider.value); this.draw(); });
    }
    if (mesh.field) this.legend(row);
    tool(figure, 'PNG', `Download “${mesh.title}” as picture`, () => this.canvas.toBlob(blob => {
      const link = htmlElement('a', { download: figure.dataset.file + '.png', href: URL.createObjectURL(blob) });
      link.click();
    }));
  }

  legend(row) {
    const { field } = this.mesh;
    this.range = fitRange({ scale: 'linear' }, field.values, 0);
    // A minimum that is zero up to rounding is shown as zero.
    if (Math.abs(this.range[0]) < 1e-9 * Math.abs(this.range[1])) this.range[0] = 0;
    const box = htmlElement('div', {}, row, `${field.label} `);
    htmlElement('span', {}, box, formatValue(this.range[0], 3) + ' ');
    htmlElement('span', { style: `display:inline-block;width:120px;height:10px;border-radius:2px;background:linear-gradient(90deg,${[0, .2, .4, .6, .8, 1].map(ramp).join(',')})` }, box);
    htmlElement('span', {}, box, ' ' + withUnit(formatValue(this.range[1], 3), field.unit));
  }

  draw() {
    const { mesh, canvas } = this, width = canvas.clientWidth, sharp = Math.max(2, window.devicePixelRatio || 1);
    if (!width) return;
    canvas.width = canvas.height = Math.round(width * sharp);
    const context = canvas.getContext('2d'), margin = 0.04 * canvas.width, scale = (canvas.width - 2 * margin) / this.extent.size;
    const exaggeration = this.part * this.full * 1e-3;
    const place = node => {
      const dx = this.moved ? mesh.displacement_um[2 * node] * exaggeration : 0, dy = this.moved ? mesh.displacement_um[2 * node + 1] * exaggeration : 0;
      return [canvas.width / 2 + (mesh.nodes_mm[2 * node] + dx - this.extent.x) * scale, canvas.width / 2 - (mesh.nodes_mm[2 * node + 1] + dy - this.extent.y) * scale];
    };
    const style = getComputedStyle(document.documentElement);
    context.lineWidth = Math.max(0.5, 0.35 * sharp);
    context.strokeStyle = style.getPropertyValue('--metal-edge');
    for (const triangle of mesh.triangles) {
      const [a, b, c] = triangle.map(place);
      context.beginPath(); context.moveTo(...a); context.lineTo(...b); context.lineTo(...c); context.closePath();
      if (mesh.field) {
        const mean = (mesh.field.values[triangle[0]] + mesh.field.values[triangle[1]] + mesh.field.values[triangle[2]]) / 3;
        context.fillStyle = ramp((mean - this.range[0]) / (this.range[1] - this.range[0] || 1));
        context.fill();
        context.globalAlpha = 0.35;
      }
      context.stroke();
      context.globalAlpha = 1;
    }
    if (this.readout) this.readout.textContent = `shown ${formatValue(this.part * this.full, 2)} times larger`;
  }
}

function bounds(flat) {
  let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
  for (let at = 0; at + 1 < flat.length; at += 2) {
    x0 = Math.min(x0, flat[at]); x1 = Math.max(x1, flat[at]); y0 = Math.min(y0, flat[at + 1]); y1 = Math.max(y1, flat[at + 1]);
  }
  return { x: (x0 + x1) / 2, y: (y0 + y1) / 2, size: Math.max(x1 - x0, y1 - y0) || 1 };
}
