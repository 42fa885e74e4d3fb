// Brings meshes to the graphics card ahead of their time: an update at a time, in slices of a bounded size, into the buffer sets that
// are not drawn. Each update is applied to both sets, and forgotten then.
import { costOf, costOfChannel, kCallCost, type BufferSet } from './blend_buffers.js';
import { kChannels, type ChannelName, type Elements, type MeshUpdate, type PartLines, type PartUpdate } from '../core/mesh_update.js';

const kParts = ['terrain', 'objects'] as const;
type PartName = (typeof kParts)[number];

// One of two, with buffers for both parts of the mesh.
export interface MeshSet {
  terrain: BufferSet;
  objects: BufferSet;
}

// A set, and how far it is.
interface Staged {
  readonly set: MeshSet;
  version: number; // that it holds, unless `open`
  update: MeshUpdate | null; // the last one that was begun
  open: Slices | null; // what remains of it
}

// What remains to be uploaded of updates that follow one another.
class Slices {
  private readonly work: { part: PartName; channel: ChannelName; ranges: Uint32Array; data: Elements }[] = [];
  private range = 0; // of the first channel that remains
  private begun = 0; // numbers of that range that are there
  private read = 0; // numbers of that channel that are there
  cost = 0;
  readonly update: MeshUpdate; // the last one

  constructor(updates: readonly MeshUpdate[], private readonly set: MeshSet) {
    this.update = updates[updates.length - 1]!;
    for (const part of kParts) {
      // What is made anew needs nothing of what came before.
      const whole = updates.findLastIndex((u) => u[part].is_whole);
      for (const update of updates.slice(Math.max(whole, 0))) this.addPart(part, update[part]);
    }
  }

  private addPart(part: PartName, { channels, is_whole, triangles }: PartUpdate): void {
    this.set[part].triangles = triangles;
    this.set[part].has_lines = channels.line !== undefined;
    this.set[part].tells_moved = channels.to_moved !== undefined;
    this.set[part].tells_bends = channels.to_bend !== undefined;
    for (const channel of kChannels) {
      const update = channels[channel];
      if (!update) continue;
      this.set[part].reserve(channel, update, is_whole || channel === 'line');
      this.work.push({ part, channel, ranges: update.ranges, data: update.data });
      this.cost += costOfChannel(update);
    }
  }

  // Uploads what costs about `budget`; gives what it cost.
  step(budget: number): number {
    let spent = 0;
    while (this.work.length > 0 && spent < budget) {
      const { part, channel, ranges, data } = this.work[0]!;
      if (this.range >= ranges.length) {
        this.work.shift();
        this.range = this.read = 0;
        continue;
      }
      const [begin, end] = [ranges[this.range]! + this.begun, ranges[this.range + 1]!];
      const affordable = Math.max(1024, Math.floor((budget - spent) / data.BYTES_PER_ELEMENT));
      const count = Math.min(end - begin, affordable);
      this.set[part].write(channel, data, this.read, begin, count);
      this.read += count;
      this.begun += count;
      if (begin + count === end) {
        this.range += 2;
        this.begun = 0;
      }
      spent += kCallCost + count * data.BYTES_PER_ELEMENT;
    }
    this.cost = Math.max(0, this.cost - spent);
    return spent;
  }
  isDone(): boolean {
    return this.work.length === 0;
  }
}

export class Stage {
  private shown: Staged;
  private hidden: Staged;
  private updates: MeshUpdate[] = []; // that a set lacks, in their order

  constructor(one: MeshSet, other: MeshSet) {
    this.shown = { set: one, version: 0, update: null, open: null };
    this.hidden = { set: other, version: 0, update: null, open: null };
  }

  add(update: MeshUpdate): void {
    this.updates.push(update);
  }

  get shownVersion(): number {
    return this.shown.version;
  }
  // Of the newest mesh that can be shown.
  get readyVersion(): number {
    return this.hidden.open ? this.shown.version : Math.max(this.hidden.version, this.shown.version);
  }
  // Whether the mesh that follows the one that is shown is.
  get isNextReady(): boolean {
    return this.shown.version > 0 && !this.hidden.open && this.hidden.version === this.shown.version + 1;
  }
  // Whether there is something to do on the way to `version`: also for an update that changes nothing, which is to become ready.
  hasWork(version: number): boolean {
    return this.hidden.open !== null || this.updates.some((u) => u.version > this.hidden.version && u.version <= version);
  }
  // Of the mesh that is being brought to the card; 0: none.
  get comingVersion(): number {
    return this.hidden.open?.update.version ?? 0;
  }
  // Of the newest mesh that is on the card, or on its way there.
  get stagedVersion(): number {
    return Math.max(this.hidden.update?.version ?? 0, this.shown.version);
  }

  // Shows what is ready. Gives the update that it is of, and the set that holds it.
  swap(): { update: MeshUpdate; set: MeshSet } {
    [this.shown, this.hidden] = [this.hidden, this.shown];
    return { update: this.shown.update!, set: this.shown.set };
  }

  // Whether what is drawn belongs elsewhere, as after a jump: a mesh on the way to `version` follows from none and takes its place at once.
  isElsewhere(version: number): boolean {
    return this.updates.some((u) => u.version > this.shown.version && u.version <= version && u.oldest_version === u.version && u.terrain.is_whole);
  }
  // What it costs to make `version` ready.
  costTo(version: number): number {
    let cost = this.hidden.open?.cost ?? 0;
    const from = this.hidden.open?.update.version ?? this.hidden.version;
    for (const u of this.updates) if (u.version > from && u.version <= version) cost += costOf(u.terrain) + costOf(u.objects);
    return cost;
  }

  // Brings the set that is not drawn towards `version`, by about `budget` of cost; gives what it cost.
  upload(version: number, budget: number): number {
    const { hidden } = this;
    let spent = 0;
    while (spent < budget) {
      if (!hidden.open && !this.beginNext(version)) break;
      spent += hidden.open!.step(budget - spent);
      if (!hidden.open!.isDone()) break;
      hidden.version = hidden.open!.update.version;
      hidden.open = null;
    }
    const held = Math.min(this.shown.version, hidden.version);
    while (this.updates.length > 0 && this.updates[0]!.version <= held) this.updates.shift();
    return spent;
  }

  // The lines of a mesh that came without.
  addLines(version: number, terrain: PartLines, objects: PartLines): void {
    for (const staged of [this.shown, this.hidden]) {
      if (staged.version !== version || staged.open) continue;
      staged.set.terrain.fillLines(terrain);
      staged.set.objects.fillLines(objects);
    }
  }

  private beginNext(version: number): boolean {
    const { hidden } = this;
    const updates = this.updates.filter((u) => u.version > hidden.version && u.version <= version);
    if (updates.length === 0) return false;
    hidden.open = new Slices(updates, hidden.set);
    hidden.update = hidden.open.update;
    return true;
  }
}
