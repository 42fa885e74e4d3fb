// Pictures of pins: red is the pin, with a dark rim, and yellow what is on it (mark.frag.glsl).

// Outlines in a square from -1 to 1, y downward, of names that Maki has.
const kOutlines: Record<string, readonly (readonly [number, number])[]> = {
  mountain: [[-1, 0.75], [-0.25, -0.75], [0.1, -0.1], [0.35, -0.4], [1, 0.75]],
  volcano: [[-1, 0.75], [-0.35, -0.5], [0, -0.25], [0.35, -0.5], [1, 0.75]],
  triangle: [[-0.9, 0.7], [0, -0.85], [0.9, 0.7]],
  square: [[-0.7, -0.7], [0.7, -0.7], [0.7, 0.7], [-0.7, 0.7]],
  campsite: [[-1, 0.75], [0, -0.9], [1, 0.75], [0.35, 0.75], [0, 0.1], [-0.35, 0.75]],
  shelter: [[-1, 0], [0, -0.85], [1, 0], [0.65, 0], [0.65, 0.8], [-0.65, 0.8], [-0.65, 0]],
  cross: [[-0.25, -0.85], [0.25, -0.85], [0.25, -0.25], [0.85, -0.25], [0.85, 0.25], [0.25, 0.25], [0.25, 0.85], [-0.25, 0.85], [-0.25, 0.25], [-0.85, 0.25], [-0.85, -0.25], [-0.25, -0.25]],
  star: Array.from({ length: 10 }, (_, i) => [Math.sin((i * Math.PI) / 5) * (i % 2 ? 0.42 : 1), -Math.cos((i * Math.PI) / 5) * (i % 2 ? 0.42 : 1)] as const),
};
const kSame: Record<string, string> = { home: 'shelter', lodging: 'shelter', building: 'shelter', hospital: 'cross', 'religious-christian': 'cross', 'star-stroked': 'star', 'triangle-stroked': 'triangle', 'square-stroked': 'square' };

// In the upper half of a square, its tip in the middle of that.
export function drawPin(context: CanvasRenderingContext2D, side: number, symbol: string): void {
  const [x, r] = [side / 2, side * 0.165], y = r + side * 0.02;
  context.beginPath();
  context.arc(x, y, r, Math.PI * 0.87, Math.PI * 0.13);
  context.lineTo(x, side / 2);
  context.closePath();
  context.fillStyle = '#f00';
  context.fill();
  context.strokeStyle = '#000';
  context.lineWidth = side * 0.02;
  context.lineJoin = 'round';
  context.stroke();
  context.fillStyle = '#ff0';
  drawSymbol(context, x, y, r, symbol);
}

// A letter or two digits, an outline; otherwise a disc.
function drawSymbol(context: CanvasRenderingContext2D, x: number, y: number, r: number, symbol: string): void {
  const outline = kOutlines[kSame[symbol] ?? symbol];
  context.beginPath();
  if (/^([a-z]|\d{1,2})$/i.test(symbol)) {
    context.font = `bold ${1.35 * r}px system-ui, sans-serif`;
    Object.assign(context, { textAlign: 'center', textBaseline: 'middle' });
    context.fillText(symbol.toUpperCase(), x, y + 0.08 * r);
  } else if (outline) {
    for (const [dx, dy] of outline) context.lineTo(x + 0.66 * r * dx, y + 0.66 * r * dy);
    context.fill();
  } else {
    context.arc(x, y, 0.38 * r, 0, 2 * Math.PI);
    context.fill();
  }
}
