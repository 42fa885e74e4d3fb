// The WebSocket to the server: one binary message is one protocol message. When it is lost, it tries again after a growing wait, at
// random, so that the viewers of a server that dies do not all come in one instant. A server that stops asks its viewers to connect
// again at once (close code 1012), and says nothing to the user. A connection that takes up nothing more is given up, and made anew.
// A session that the server refused is not tried again automatically. Where a WebSocket does not open, browsers do not say why: the same
// address is asked by plain HTTP (refusal.ts), and what it says is passed on.
import { reasonOf } from '../core/failure.js';
import { askWhy } from '../core/refusal.js';
import { addressIn } from '../core/area.js';

export interface ConnectionEvents {
  onOpen(): void;
  onMessage(message: Uint8Array): void;
  onWaiting(seconds: number, reason: string): void; // until the next attempt; the reason is a sentence, or empty
  onMigrate(): void; // the server hands its viewers over: another connection is opened at once
  onImpossible(reason: string): void; // the browser does not connect to such an address; a sentence
}

const kFirstWait_ms = 500;
const kLongestWait_ms = 8000;
const kHandOver = 1012;
const kPatience = 3; // a server that has been there may be about to come back: so often it is tried without asking why it does not answer
const kMaxUnsent_bytes = 1 << 20; // beside the largest message

export class Connection {
  private socket: WebSocket | null = null;
  private largest_bytes = 0; // of the messages of this connection: sections to resume from and paths are large
  private wait_ms = kFirstWait_ms;
  private announced_ms = 0; // the last wait
  private timer: ReturnType<typeof setTimeout> | undefined; // of the attempt that it waits for
  private is_hidden = false;
  private waits_to_be_seen = false;
  private failures = 0; // to open, in a row
  private has_been_open = false;
  private why = ''; // it did not open, as far as is known
  private is_asking = false;

  // `area` is that of a large scene, which the address says, for proxies that lead viewers of the same ground to the same server. `ask` gives
  // sentences that say why a WebSocket does not open at an address, or nothing; it never rejects.
  constructor(private url: string, private readonly events: ConnectionEvents, private readonly area: () => number | null = () => null, private readonly ask = askWhy) {}

  open(): void {
    this.close();
    const socket = this.newSocket();
    if (!socket) return;
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.largest_bytes = 0;
    let has_opened = false;
    socket.onopen = () => {
      has_opened = this.has_been_open = true;
      [this.failures, this.why] = [0, ''];
      this.events.onOpen();
    };
    socket.onerror = () => {}; // onclose follows; where nobody listens Node ends the thread
    socket.onmessage = (event) => {
      if (socket !== this.socket || !(event.data instanceof ArrayBuffer)) return;
      this.wait_ms = kFirstWait_ms;
      this.events.onMessage(new Uint8Array(event.data));
    };
    socket.onclose = (event) => {
      if (socket !== this.socket) return;
      if (event.code === kHandOver && this.wait_ms === kFirstWait_ms) this.reopenAtOnce();
      else this.waitAndReopen(event.reason !== '' ? `The server said: ${event.reason}.` : has_opened ? '' : this.why);
      if (!has_opened && ++this.failures >= (this.has_been_open ? kPatience : 1)) void this.learnWhy();
    };
  }

  // Ends the connection for good; open() begins anew.
  close(): void {
    this.waits_to_be_seen = false;
    clearTimeout(this.timer);
    this.timer = undefined;
    const socket = this.socket;
    this.socket = null;
    socket?.close();
  }

  // For the next attempt.
  setUrl(url: string): void {
    this.url = url;
  }

  private address(): string {
    const area = this.area();
    return area === null ? this.url : addressIn(this.url, area);
  }

  isOpen(): boolean {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  // Messages are coded against earlier ones, so none of a connection may be left out: all are sent until it is given up.
  send(message: Uint8Array<ArrayBuffer>): void {
    const { socket } = this;
    if (socket?.readyState !== WebSocket.OPEN) return;
    this.largest_bytes = Math.max(this.largest_bytes, message.length);
    if (socket.bufferedAmount > kMaxUnsent_bytes + this.largest_bytes) this.giveUp();
    else socket.send(message);
  }

  private giveUp(): void {
    this.close();
    this.waitAndReopen('The network took up nothing more.');
  }

  private newSocket(): WebSocket | null {
    try {
      return new WebSocket(this.address());
    } catch (error) {
      this.events.onImpossible(`The browser does not connect to ${this.url}: ${reasonOf(error)}`);
      return null;
    }
  }

  // Tells of it at once, if it still waits for the same attempt.
  private async learnWhy(): Promise<void> {
    if (this.is_asking) return;
    this.is_asking = true;
    const { timer } = this;
    const why = await this.ask(this.url);
    this.is_asking = false;
    this.why = why;
    if (why !== '' && timer !== undefined && timer === this.timer) this.events.onWaiting(this.announced_ms / 1000, why);
  }

  // Once, until a message has arrived.
  private reopenAtOnce(): void {
    this.events.onMigrate();
    this.open();
    this.wait_ms = 2 * kFirstWait_ms;
  }

  private waitAndReopen(reason: string): void {
    this.socket = null;
    this.announced_ms = this.wait_ms;
    this.events.onWaiting(this.wait_ms / 1000, reason);
    this.timer = setTimeout(() => this.reopen(), this.wait_ms * (0.5 + 0.5 * Math.random()));
    this.wait_ms = Math.min(2 * this.wait_ms, kLongestWait_ms);
  }

  // A page that nobody sees sends no poses, so the server would only close again: it waits to be seen.
  private reopen(): void {
    if (this.is_hidden) this.waits_to_be_seen = true;
    else this.open();
  }

  // Whether nobody sees the page.
  setHidden(is_hidden: boolean): void {
    this.is_hidden = is_hidden;
    if (!is_hidden && this.waits_to_be_seen) this.open();
  }
}
