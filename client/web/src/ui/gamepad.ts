// A gamepad, or a headset's: the left stick moves, the right one looks, the triggers sink and rise, the right shoulder is faster. Read with each frame.

const kDead = 0.15; // of a stick's way, in which it rests

export interface PadState {
  move: readonly [right: number, ahead: number, up: number]; // -1 to 1
  look: readonly [right: number, up: number];
  is_faster: boolean;
}

// What is held of the first pad with the standard layout; null where none is, or nothing is moved.
export function padState(pads: readonly (Pick<Gamepad, 'mapping' | 'axes' | 'buttons' | 'connected'> | null)[]): PadState | null {
  const pad = pads.find((each) => each?.connected && each.mapping === 'standard');
  if (!pad) return null;
  const axis = (i: number) => alive(pad.axes[i] ?? 0), button = (i: number) => pad.buttons[i]?.value ?? 0;
  const move = [axis(0), 0 - axis(1), alive(button(7) - button(6))] as const, look = [axis(2), 0 - axis(3)] as const;
  return [...move, ...look].every((v) => v === 0) ? null : { move, look, is_faster: button(5) > 0.5 };
}

// What is held of a headset's: the left stick moves, the right one turns and rises, its trigger is faster.
export function headsetPad(sources: Iterable<Pick<XRInputSource, 'handedness' | 'gamepad'>>): PadState | null {
  let [move_x, move_y, turn, rise, is_faster] = [0, 0, 0, 0, false];
  for (const { handedness, gamepad } of sources) {
    if (gamepad?.mapping !== 'xr-standard') continue;
    const [x, y] = [alive(gamepad.axes[2] ?? 0), 0 - alive(gamepad.axes[3] ?? 0)];
    if (handedness === 'left') [move_x, move_y] = [x, y];
    else [turn, rise, is_faster] = [x, y, (gamepad.buttons[0]?.value ?? 0) > 0.5];
  }
  return [move_x, move_y, turn, rise].every((v) => v === 0) ? null : { move: [move_x, move_y, rise], look: [turn, 0], is_faster };
}

// From 0 on outside of the dead part.
function alive(value: number): number {
  const way = Math.min(Math.abs(value), 1) - kDead;
  return way <= 0 ? 0 : (Math.sign(value) * way) / (1 - kDead);
}
