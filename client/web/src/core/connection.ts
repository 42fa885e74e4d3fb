// The WebSocket to the server: one binary message is one protocol message. When it is lost, it tries again after a growing wait, at
// random, so that the viewers of a server that dies do not all come in one instant. A server that stops asks its viewers to connect
// again at once (close code 1012), and says nothing to the user.
// A session that the server refused is not tried again automatically.

export interface ConnectionEvents {
  onOpen(): void;
  onMessage(message: Uint8Array): void;
  onWaiting(seconds: number, reason: string): void; // until the next attempt; the reason is the server's, or empty
}

const kFirstWait_ms = 500;
const kLongestWait_ms = 8000;
const kHandOver = 1012;
const kMostUnsent_bytes = 1 << 20; // poses are dropped beyond it: newer ones follow

export class Connection {
  private socket: WebSocket | null = null;
  private wait_ms = kFirstWait_ms;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private is_hidden = false;
  private waits_to_be_seen = false;

  constructor(readonly url: string, private readonly events: ConnectionEvents) {}

  open(): void {
    this.waits_to_be_seen = false;
    clearTimeout(this.timer);
    this.close();
    const socket = new WebSocket(this.url);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    socket.onopen = () => this.events.onOpen();
    socket.onmessage = (event) => {
      if (socket !== this.socket || !(event.data instanceof ArrayBuffer)) return;
      this.wait_ms = kFirstWait_ms;
      this.events.onMessage(new Uint8Array(event.data));
    };
    socket.onclose = (event) => {
      if (socket !== this.socket) return;
      if (event.code === kHandOver && this.wait_ms === kFirstWait_ms) this.reopenAtOnce();
      else this.waitAndReopen(event.reason);
    };
  }

  // Ends the connection for good; open() begins anew.
  close(): void {
    this.waits_to_be_seen = false;
    clearTimeout(this.timer);
    const socket = this.socket;
    this.socket = null;
    socket?.close();
  }

  isOpen(): boolean {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  send(message: Uint8Array<ArrayBuffer>): void {
    if (this.socket?.readyState === WebSocket.OPEN && this.socket.bufferedAmount < kMostUnsent_bytes) this.socket.send(message);
  }

  // Once, until a message has arrived.
  private reopenAtOnce(): void {
    this.open();
    this.wait_ms = 2 * kFirstWait_ms;
  }

  private waitAndReopen(reason: string): void {
    this.socket = null;
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
