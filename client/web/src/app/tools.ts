// What is done by hand beside flying: each tool has its button, its keys and its card.
import type { Controls } from '../ui/controls';
import { CutControl } from '../ui/cut_control';
import { FollowControl } from '../ui/follow_control';
import { HeadsetControl } from '../ui/headset_control';
import { LabelControl } from '../ui/label_control';
import { MeasureControl } from '../ui/measure_control';
import { OverlayControl } from '../ui/overlay_control';
import { RecordControl } from '../ui/record_control';
import { ShareControl } from '../ui/share_control';
import { SightControl } from '../ui/sight_control';
import type { Stage } from '../ui/stage';
import { WaypointControl } from '../ui/waypoint_control';

export const kNotLaid = 'This file cannot be laid on the ground';

// What they need of the page beside the stage.
export interface ToolPage {
  stage: Stage;
  controls: Controls;
  needs_token: boolean;
  refuse(title: string, reason: string): void; // a file
  guide(): void; // a flight takes the camera, or leaves it
  link(): string; // that leads to what is seen
  beginFrames(): void; // the page draws no more
  endFrames(): void;
}

export class Tools {
  readonly sight: SightControl;
  readonly measure: MeasureControl;
  readonly cut: CutControl;
  readonly labels: LabelControl;
  readonly overlays: OverlayControl;
  readonly follow: FollowControl;
  readonly waypoints: WaypointControl;
  readonly record: RecordControl;
  readonly headset: HeadsetControl;

  constructor(byId: (id: string) => HTMLElement, page: ToolPage) {
    const { stage, controls } = page, bar = byId('tools');
    this.sight = new SightControl(stage);
    this.measure = new MeasureControl(bar, byId('measure'), stage, (corners) => void this.cut.cutAlong(corners));
    this.cut = new CutControl(bar, byId('cut'), stage);
    this.labels = new LabelControl(stage);
    this.overlays = new OverlayControl(byId('overlays'), byId('feature'), { ...stage, isTaken: () => this.measure.isOn, refuse: (reason) => page.refuse(kNotLaid, reason) }, this.labels);
    this.follow = new FollowControl(byId('follow'), stage, () => page.guide(), () => this.record.refresh());
    this.waypoints = new WaypointControl(bar, byId('waypoints'), stage, controls, this.follow);
    const pose = () => controls.pose(stage.picture().up);
    this.record = new RecordControl(bar, byId('record'), { ...stage, pose, beginFrames: () => page.beginFrames(), endFrames: () => page.endFrames() }, this.follow);
    new ShareControl(bar, byId('share'), () => page.link(), page.needs_token, (text) => stage.say(text));
    this.headset = new HeadsetControl(bar, stage);
    closeOthersIn(bar);
  }

  // In a picture that took another one's place.
  show(): void {
    this.sight.show();
    this.measure.show();
    this.cut.show();
    this.follow.show();
    this.overlays.showAgain();
  }

  status(): Record<string, unknown> {
    const { sight, measure, cut, labels, overlays, follow, waypoints, record } = this;
    return Object.assign({}, ...[sight, measure, cut, labels, overlays, follow, waypoints, record].map((tool) => tool.status()));
  }
}

// There is room for one card: opening one closes the others.
function closeOthersIn(bar: HTMLElement): void {
  bar.addEventListener('click', ({ target }) => {
    if (!(target instanceof HTMLButtonElement) || target.getAttribute('aria-pressed') !== 'true') return;
    for (const button of bar.querySelectorAll<HTMLButtonElement>("button[aria-pressed='true']")) if (button !== target) button.click();
  });
}
