// Headless Chromium, and what it says of its own traffic.
import { chromium } from 'playwright-core';

const kFlags = ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage', '--site-per-process=false'];

export const openBrowser = () => chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: kFlags });

// Counts what goes to and comes from `port`: of requests the bytes with their headers as they came (encodedDataLength), of
// WebSockets the payloads of frames, in the page and in its workers. `mark` keeps what has been counted by then under a name.
export async function countTraffic(page, port) {
  const cdp = await page.context().newCDPSession(page);
  const now = { bytes: 0, requests: 0, from_cache: 0, failed: 0, messages_up: 0, messages_down: 0 }, marks = {}, counted = new Set();
  const listeners = {
    'Network.requestWillBeSent': ({ requestId, request: { url } }) => void (isRequestTo(url, port) && (counted.add(requestId), ++now.requests)),
    'Network.requestServedFromCache': ({ requestId }) => void (now.from_cache += counted.has(requestId)),
    'Network.loadingFinished': ({ requestId, encodedDataLength }) => void (now.bytes += counted.has(requestId) ? encodedDataLength : 0),
    'Network.loadingFailed': ({ requestId }) => void (now.failed += counted.has(requestId)),
    'Network.webSocketFrameReceived': ({ response }) => void (++now.messages_down, now.bytes += lengthOf(response)),
    'Network.webSocketFrameSent': () => void ++now.messages_up,
  };
  for (const [name, listener] of Object.entries(listeners)) cdp.on(name, listener);
  // A worker is a target of its own, whose messages come by those of the page.
  const tell = (sessionId, id, method) => cdp.send('Target.sendMessageToTarget', { sessionId, message: JSON.stringify({ id, method }) }).catch(() => {});
  cdp.on('Target.receivedMessageFromTarget', ({ message }) => { const { method, params } = JSON.parse(message); listeners[method]?.(params); });
  cdp.on('Target.attachedToTarget', async ({ sessionId }) => { await tell(sessionId, 1, 'Network.enable'); await tell(sessionId, 2, 'Runtime.runIfWaitingForDebugger'); });
  await cdp.send('Network.enable');
  await cdp.send('Target.setAutoAttach', { autoAttach: true, waitForDebuggerOnStart: true, flatten: false });
  return { now, marks, mark: (name) => void (marks[name] = { ...now }) };
}

const isRequestTo = (url, port) => /^https?:/.test(url) && new URL(url).port === String(port);
// Binary payloads are told in base64.
const lengthOf = ({ opcode, payloadData }) => Buffer.byteLength(payloadData, opcode === 2 ? 'base64' : 'utf8');
