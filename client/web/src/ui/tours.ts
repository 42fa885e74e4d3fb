// The tours: the server plans a path, and the page flies it. A button for each starts and stops it.
import type { Pose, Terrain } from '@foreland/client';
import { said } from './language';
import { kTours, type Tour } from './settings';

const kTour_s = 180;
const kLead_ms = 700; // between the plan's arrival and the start, so that the server can send the first keyframe there in time
const kTitles: Record<Tour, string> = { survey: 'Survey', canyon: 'Canyon', spin: 'Spin', orbit: 'Orbit' };

export class Tours {
  private readonly buttons = new Map<Tour, HTMLButtonElement>();
  private wanted: Tour | null = null; // requested, and flown once its plan has arrived
  private is_flying = false;

  // `shown` gives how a pose is drawn that the server knows.
  constructor(bar: HTMLElement, private readonly onChoice: (tour: Tour | null) => void, private readonly shown: (pose: Pose) => Pose) {
    for (const tour of kTours) {
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = said(kTitles[tour]);
      button.dataset.tour = tour;
      button.setAttribute('aria-pressed', 'false');
      button.onclick = () => this.onChoice(this.wanted === tour ? null : tour);
      bar.append(button);
      this.buttons.set(tour, button);
    }
  }

  get current(): Tour | null {
    return this.wanted;
  }
  get isFlying(): boolean {
    return this.is_flying;
  }

  request(tour: Tour, terrain: Terrain): void {
    this.wanted = tour;
    this.is_flying = false;
    terrain.requestTour(tour, kTour_s);
    this.showChoice();
  }

  stop(): void {
    this.wanted = null;
    this.is_flying = false;
    this.showChoice();
  }

  // The camera on the tour; null when none is flown. A tour that is over stops.
  pose(terrain: Terrain, now_ms: number): Pose | null {
    if (terrain.hasTour && this.wanted !== null) {
      terrain.startTour(now_ms + kLead_ms);
      terrain.jump(); // to where it begins
      this.is_flying = true;
    }
    if (!this.is_flying) return null;
    const pose = terrain.tourPose(now_ms);
    if (!pose) this.onChoice(null);
    return pose && this.shown(pose);
  }

  private showChoice(): void {
    for (const [tour, button] of this.buttons) button.setAttribute('aria-pressed', String(tour === this.wanted));
  }
}
