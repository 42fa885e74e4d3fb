// How to move, for whom the page is new: three lines on the first visit, one later.
import { said } from './language';
import { isRemembered, remember } from './remembered';

const kMouse = ['Drag to look around', 'W A S D or the arrows fly, E and Q rise and sink', 'The wheel sets the speed, shift-click and V show what is seen'];
const kFingers = ['One finger looks around', 'Two fingers carry you over the ground', 'Pinch to fly ahead'];

export function wordsOnMoving(is_phone: boolean): string {
  const is_first = !isRemembered('visited');
  remember('visited', true);
  if (is_first) return (is_phone ? kFingers : kMouse).map(said).join('\n');
  return is_phone ? 'One finger looks, two fingers fly' : 'Drag to look \u00b7 W A S D to fly \u00b7 wheel sets the speed';
}
