// The button that shows the scene in a headset, where the browser has one. On maps alone: a globe is drawn on a canvas of its own depths.
import type { Scene } from '@foreland/client';
import { said } from './language';
import type { Stage } from './stage';
import { reasonOf } from './words';

export class HeadsetControl {
  private readonly button = Object.assign(document.createElement('button'), { type: 'button' as const, name: 'headset', textContent: said('VR'), title: 'See it in a headset', hidden: true });
  private is_supported = false;

  constructor(tools: HTMLElement, private readonly stage: Stage) {
    this.button.onclick = () => void this.turn();
    tools.append(this.button);
    navigator.xr?.isSessionSupported('immersive-vr').then((is_supported) => {
      this.is_supported = is_supported;
      this.show();
    }, () => {}); // forbidden, as in a frame of another page: none
  }

  setScene({ frame }: Scene): void {
    this.button.dataset.frame = frame;
    this.show();
  }
  private show(): void {
    const { frame } = this.button.dataset;
    this.button.hidden = !this.is_supported || frame === undefined || frame === 'globe';
  }

  private async turn(): Promise<void> {
    const { headset } = this.stage.picture();
    if (headset.session) return headset.session.end();
    try {
      await headset.begin(await navigator.xr!.requestSession('immersive-vr'));
    } catch (error) {
      this.stage.say(`The headset does not show it: ${reasonOf(error)}`);
    }
  }
}
