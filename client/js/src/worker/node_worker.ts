// The worker in a thread of Node, which looks to it like a browser's.
import { parentPort } from 'node:worker_threads';

const port = parentPort!;
type Listener = (event: any) => void;
const listeners: Record<string, (listener: Listener) => void> = {
  message: (listener) => port.on('message', (data) => listener({ data })),
  messageerror: (listener) => port.on('messageerror', listener),
  error: (listener) => process.on('uncaughtException', (error) => listener({ error, preventDefault() {} })),
  unhandledrejection: (listener) => process.on('unhandledRejection', (reason) => listener({ reason, preventDefault() {} })),
};

async function socketOfPackage(): Promise<unknown> {
  try {
    return (await import('ws')).WebSocket;
  } catch (error) {
    throw new Error('This version of Node has no WebSocket: npm install ws, or use Node 22.', { cause: error });
  }
}

Object.assign(globalThis, {
  self: { postMessage: (message: unknown, memory: any) => port.postMessage(message, memory), addEventListener: (name: string, listener: Listener) => listeners[name]?.(listener) },
  WebSocket: globalThis.WebSocket ?? (await socketOfPackage()),
});
// @ts-ignore: it is beside this file once both are built.
await import('./worker.js');
