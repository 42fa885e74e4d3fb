// How to move, for whom the page is new: three lines on the first visit, one later.
import { said } from './language';
import { isRemembered, remember } from './remembered';

const kMouse = ['Drag to look around', 'W A S D or the arrows fly, E and Q rise and sink', 'The wheel sets the speed, shift-click and V show what is seen'];
const kFingers = ['One finger looks around', 'Pinch to near the ground, twist to turn', 'Two fingers up or down tilt, three carry you'];

const kGlobeMouse = ['Drag the ground, the wheel nears what you point at', 'The right button tilts, beside the ground you look around', 'W A S D or the arrows fly, E and Q rise and sink'];
const kGlobeFingers = ['One finger drags the ground', 'Pinch to near it, twist to turn', 'Two fingers up or down tilt'];

export function wordsOnMoving(is_phone: boolean, is_globe: boolean): string {
  const is_first = !isRemembered('visited');
  remember('visited', true);
  if (is_first) return (is_globe ? (is_phone ? kGlobeFingers : kGlobeMouse) : is_phone ? kFingers : kMouse).map(said).join('\n');
  if (is_globe) return is_phone ? 'One finger drags, two near and tilt' : 'Drag the ground \u00b7 wheel nears \u00b7 right button tilts \u00b7 W A S D to fly';
  return is_phone ? 'One finger looks, two near and tilt' : 'Drag to look \u00b7 W A S D to fly \u00b7 wheel sets the speed';
}
