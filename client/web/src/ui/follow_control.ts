// Following a flight: K plays and pauses, J and L go ten seconds back and on, comma and full stop change the play speed, F the view. While the
// camera goes along, its path is announced to the server, piece by piece, so that each frame's error is guaranteed.
import type { Pose, Scene, Terrain, Vector } from '@foreland/client';
import { upIn } from '../follow/basis';
import { poseOn, type CameraPath } from '../follow/camera_path';
import { durationOf, pointAt, velocityAt } from '../follow/flight';
import { journeyOf, type Journey } from '../follow/journey';
import { hasTimes, trackOf, type TrackMap } from '../follow/track';
import { titleOf, toMapOf } from '../overlay/map_coordinates';
import { FollowBar, kSpeeds, type View } from './follow_bar';
import { isForPage, type Stage } from './stage';

const kLongestWait_ms = 5000; // for a guarantee where the flight goes on
const kSpare_ms = 300; // between a path's announcement and its start, beside the two keyframes that are under way
const kPiece = 1200; // poses that are announced at once
const kBefore = 2; // of them before where the camera is, where it is on its way: a path is smooth between two poses on either side
const kLeft_ms = 30_000; // of a piece, when the next one is announced
const kAround_s = 10; // by a key
const kLongest_s = 240, kFastest = 10; // of a flight that is shown at first

// What is shown of a flight at a time, for a recorder as well.
export interface Followed {
  time_s: number;
  journey: Journey;
  path: CameraPath;
  speed: number;
}

export class FollowControl {
  private journey: Journey | null = null;
  private path: CameraPath | null = null; // of the view; null: free, or not known yet
  private view: View = 'free';
  private speed = 1;
  private is_playing = false;
  private from_ms = 0; // it is at from_s until then, and goes on from there; Infinity: it waits
  private since_ms = 0; // that it waits
  private frames = 0; // since then
  private from_s = 0;
  private piece: (CameraPath & { from_s: number; until_ms: number }) | null = null; // that is announced
  private has_jumped = false;
  private is_dragged = false;
  private made = 0; // paths so far
  private at: Vector = [0, 0, 0]; // of the aircraft, in the last frame
  private readonly bar: FollowBar;

  // `onGuide` is called as the camera begins to go along, or ends it; `onPath` as its path is known, or gone.
  constructor(root: HTMLElement, private readonly stage: Stage, private readonly onGuide: () => void, private readonly onPath: () => void) {
    this.bar = new FollowBar(root, {
      play: () => this.play(!this.is_playing), seek: (time_s, is_dragged) => this.seek(time_s, is_dragged), view: (view) => void this.choose(view, this.speed),
      speed: (speed) => void this.choose(this.view, speed), close: () => this.end(),
    });
    window.addEventListener('keydown', (event) => this.key(event));
  }

  // For tests.
  status(): Record<string, unknown> {
    const { journey, view, speed, is_playing, path } = this;
    return { following: journey?.name ?? null, follow_s: this.timeAt(performance.now()), follow_duration_s: journey ? durationOf(journey.flight) : 0,
      follow_view: view, follow_speed: speed, follow_playing: is_playing && path !== null, follow_lead: performance.now() < this.from_ms, follow_at: this.at };
  }

  // Whether it has the camera.
  get isGuiding(): boolean {
    return this.journey !== null && this.view !== 'free';
  }
  get followed(): Followed | null {
    return this.journey && this.path ? { time_s: this.timeAt(performance.now()), journey: this.journey, path: this.path, speed: this.speed } : null;
  }

  // A file of features that has a track. An Error says what is wrong with it.
  async take(name: string, json: unknown, needs_times: boolean): Promise<void> {
    const terrain = this.stage.terrain();
    if (!terrain?.hasScene || (needs_times && !hasTimes(json))) return;
    const journey = await journeyOf(terrain, trackOf(name, json, mapOf(json, terrain.scene)));
    this.begin(journey);
    this.stage.say([`${name}: K plays and pauses, J and L go back and on, F changes the view.`, ...journey.notes].join('\n'));
  }

  begin(journey: Journey): void {
    this.end();
    this.journey = journey;
    [this.from_s, this.is_playing] = [0, false];
    this.bar.show(journey);
    this.show();
    const speed = kSpeeds.find((each) => durationOf(journey.flight) / each <= kLongest_s || each === kFastest)!;
    void this.choose(journey.seats[0] ?? 'own', speed).then(() => this.play(true));
  }
  end(): void {
    ++this.made;
    const was_guiding = this.isGuiding;
    this.silence();
    this.journey = this.path = null;
    this.bar.show(null);
    this.stage.picture().flight_marks.show([]);
    if (was_guiding) this.onGuide();
    this.onPath();
  }
  pause(): void {
    this.play(false);
  }
  // A person steers.
  release(): void {
    if (this.isGuiding) void this.choose('free', this.speed);
  }

  // In a picture that took another one's place as well.
  show(): void {
    this.stage.picture().flight_marks.show(this.journey?.flight.points ?? []);
  }

  // With each frame. Where the camera is; null where it does not go along.
  pose(terrain: Terrain, now_ms: number): Pose | null {
    const { journey, path, view, speed, is_playing } = this;
    if (!journey) return null;
    const time_s = this.timeAt(now_ms);
    this.bar.update(now_ms, { time_s, is_playing, view, speed });
    this.mark(terrain, time_s);
    if (is_playing && time_s >= durationOf(journey.flight)) this.play(false);
    if (!path) return null;
    if (this.has_jumped) terrain.jump();
    this.has_jumped = false;
    if (this.is_playing && !this.is_dragged) this.fly(terrain, now_ms);
    return this.piece ? poseOn(this.piece, time_s - this.piece.from_s) : poseOn(path, time_s);
  }
  // The aircraft where it is at a time.
  mark(terrain: Terrain, time_s: number): void {
    const { flight, seats } = this.journey!, at = (this.at = pointAt(flight, time_s));
    const ahead = velocityAt(flight, time_s), segments = flight.times_s.findIndex((t) => t > time_s);
    const has_aircraft = seats.length > 0 && this.view !== 'cockpit';
    this.stage.picture().flight_marks.place(at, ahead, upIn(terrain.scene)(at), segments < 0 ? flight.points.length - 1 : Math.max(segments - 1, 0), has_aircraft);
  }

  // ---- time

  private timeAt(now_ms: number): number {
    if (!this.journey) return 0;
    const on_s = this.is_playing ? (Math.max(now_ms - this.from_ms, 0) / 1000) * this.speed : 0;
    return Math.min(this.from_s + on_s, durationOf(this.journey.flight));
  }
  // From now on from a time of the flight; where the camera goes along, as soon as what is seen there is guaranteed.
  private goOn(from_s: number): void {
    this.silence();
    const step_s = this.path?.step_s ?? 0;
    this.from_s = step_s > 0 ? step_s * Math.round(from_s / step_s) : from_s; // where a path can begin
    this.since_ms = performance.now();
    this.frames = 0;
    this.from_ms = this.view === 'free' ? this.since_ms : Infinity;
  }
  // From the beginning, once it is over.
  private play(is_playing: boolean): void {
    if (!this.journey || is_playing === this.is_playing) return;
    const time_s = this.timeAt(performance.now()), is_over = time_s >= durationOf(this.journey.flight);
    if (is_playing && is_over) this.has_jumped = true;
    this.is_playing = is_playing;
    this.goOn(is_playing && is_over ? 0 : time_s);
  }
  private seek(time_s: number, is_dragged: boolean): void {
    if (!this.journey) return;
    this.goOn(Math.min(Math.max(time_s, 0), durationOf(this.journey.flight)));
    this.is_dragged = is_dragged;
    this.has_jumped = true;
  }

  // ---- the camera

  private async choose(view: View, speed: number): Promise<void> {
    const { journey } = this, mine = ++this.made;
    if (!journey) return;
    const was_guiding = this.isGuiding, has_moved = view !== this.view;
    const time_s = this.timeAt(performance.now());
    [this.view, this.speed] = [view, speed];
    if (has_moved) this.path = null;
    this.goOn(time_s);
    if (this.isGuiding !== was_guiding) this.onGuide();
    if (view === 'free') return;
    const path = await journey.pathOf(view === 'own' ? 'cockpit' : view, speed);
    if (mine !== this.made) return;
    this.path = path;
    this.onPath();
    this.has_jumped = true;
    this.goOn(time_s);
  }

  private fly(terrain: Terrain, now_ms: number): void {
    const { keyframe_ms, longest_keyframe_ms } = terrain.request;
    const is_guaranteed = terrain.lastFrame !== null && terrain.lastFrame.guaranteedPx !== null && this.frames > 2;
    ++this.frames;
    if (this.from_ms === Infinity && (is_guaranteed || now_ms - this.since_ms > kLongestWait_ms)) this.from_ms = now_ms + kSpare_ms + 2 * Math.max(keyframe_ms, longest_keyframe_ms ?? 0);
    if (this.from_ms !== Infinity) this.announce(terrain, now_ms);
  }

  // The piece of the path that is next, on the same steps as the whole of it.
  private announce(terrain: Terrain, now_ms: number): void {
    const { path, piece, speed } = this;
    if (piece && piece.until_ms - now_ms > kLeft_ms) return;
    const { poses, step_s } = path!, step_ms = (1000 * step_s) / speed;
    const first = Math.max(Math.floor(this.timeAt(now_ms) / step_s + 1e-6) - (piece ? kBefore : 0), 0), next = poses.slice(first, first + kPiece);
    if (next.length < 2) return;
    const start = this.from_ms + ((first * step_s - this.from_s) / speed) * 1000;
    terrain.announcePath(next.map((pose) => this.stage.picture().asked(pose)), { start, stepMs: step_ms });
    this.piece = { poses: next, step_s, from_s: first * step_s, until_ms: first + kPiece >= poses.length ? Infinity : start + kPiece * step_ms };
  }
  // The camera does not go along any more, or goes elsewhere.
  private silence(): void {
    if (this.piece) this.stage.terrain()?.announcePath([]);
    this.piece = null;
  }

  private key(event: KeyboardEvent): void {
    const { journey } = this;
    if (!journey || !isForPage(event)) return;
    const views: View[] = [...(journey.seats.length > 0 ? journey.seats : (['own'] as const)), 'free'];
    const at = kSpeeds.indexOf(this.speed);
    const keys: Record<string, () => void> = {
      KeyK: () => this.play(!this.is_playing),
      KeyJ: () => this.seek(this.timeAt(performance.now()) - kAround_s * this.speed, false), KeyL: () => this.seek(this.timeAt(performance.now()) + kAround_s * this.speed, false),
      KeyF: () => void this.choose(views[(views.indexOf(this.view) + 1) % views.length]!, this.speed),
      Comma: () => void this.choose(this.view, kSpeeds[Math.max(at - 1, 0)]!), Period: () => void this.choose(this.view, kSpeeds[Math.min(at + 1, kSpeeds.length - 1)]!),
    };
    const run = keys[event.code];
    if (!run || event.repeat) return;
    event.preventDefault();
    run();
  }
}

// Files are in longitude and latitude, unless they name another system; overlays have been refused then that is not the scene's.
function mapOf(json: unknown, { frame, crs }: Scene): TrackMap {
  if (frame !== 'planar') return { is_degrees: true, toPlace: (lon, lat) => ({ lon, lat }) };
  if (typeof json === 'object' && json !== null && 'crs' in json) return { is_degrees: false, toPlace: (easting, northing) => ({ easting, northing }) };
  const toMap = toMapOf(crs);
  if (!toMap) throw new Error(`The page cannot bring a track to the scene's map, ${titleOf(crs)}.`);
  return { is_degrees: true, toPlace: (lon, lat) => {
    const [easting, northing] = toMap(lon, lat);
    return { easting, northing };
  } };
}
