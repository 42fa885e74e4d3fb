// The WebSocket to the server: one binary message is one protocol message. When it is lost, it tries again after a growing wait.
// A session that the server refused is not tried again automatically.

export interface ConnectionEvents {
  onOpen(): void;
  onMessage(message: Uint8Array): void;
  onWaiting(seconds: number, reason: string): void; // until the next attempt; the reason is the server's, or empty
}

const kFirstWait_ms = 500;
const kLongestWait_ms = 8000;
const kMostUnsent_bytes = 1 << 20; // poses are dropped beyond it: newer ones follow

export class Connection {
  private socket: WebSocket | null = null;
  private wait_ms = kFirstWait_ms;
  private timer = 0;

  constructor(readonly url: string, private readonly events: ConnectionEvents) {}

  open(): void {
    window.clearTimeout(this.timer);
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
      if (socket === this.socket) this.waitAndReopen(event.reason);
    };
  }

  // Ends the connection for good; open() begins anew.
  close(): void {
    window.clearTimeout(this.timer);
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

  private waitAndReopen(reason: string): void {
    this.socket = null;
    this.events.onWaiting(this.wait_ms / 1000, reason);
    this.timer = window.setTimeout(() => this.reopen(), this.wait_ms);
    this.wait_ms = Math.min(2 * this.wait_ms, kLongestWait_ms);
  }

  // A page that nobody sees sends no poses, so the server would only close again: it waits to be seen.
  private reopen(): void {
    if (!document.hidden) return this.open();
    document.addEventListener('visibilitychange', () => this.reopen(), { once: true });
  }
}
