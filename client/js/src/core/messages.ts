// What the two threads of a client say to each other. The worker has the connection, the client core's viewer and the meshes; the drawing
// thread has the camera, the graphics card and what a person chooses. Times are milliseconds of the drawing thread's clock.
import type { Blend, Pose, Request, Statistics, TextureLayers } from './values.js';
import type { Failure } from './failure.js';
import type { MeshUpdate, PartLines } from './mesh_update.js';
import type { SightAnswer, SightMessage } from './sight.js';

// The server's heights of the ground; NaN beyond the data. Undulations where the scene knows a geoid, else null.
export interface ExactGround {
  heights_m: Float32Array<ArrayBuffer>;
  undulations_m: Float32Array<ArrayBuffer> | null;
}

export type ToWorker =
  // First, and once. `clock_origin_ms` is performance.timeOrigin of the drawing thread.
  | { kind: 'start'; module: WebAssembly.Module; server: string; request: Request; blend: Blend; wants_lines: boolean;
      texture_layers: TextureLayers; clock_origin_ms: number; is_recorded: boolean }
  // A frame has been drawn from `pose`; meshes up to `staged_version` are on the graphics card. Ground is wanted about `eye`.
  | { kind: 'frame'; now_ms: number; pose: Pose; eye: readonly number[]; ground_reach: number; staged_version: number }
  | { kind: 'jump' } // the camera of the next frame is jumped to
  | { kind: 'request'; request: Request }
  | { kind: 'blend'; blend: Blend }
  | { kind: 'lines'; wants_lines: boolean }
  | { kind: 'scene clock'; now_ms: number; scene_ms: number; rate: number }
  | { kind: 'request tour'; name: string; seconds: number }
  | { kind: 'start tour'; start_ms: number }
  | { kind: 'path'; start_ms: number; step_ms: number; poses: Float64Array } // the camera will take; seven numbers each
  | { kind: 'ground'; id: number; positions: Float64Array } // of the lattice, x and y each
  | { kind: 'server'; url: string } // for the next attempt to connect
  | { kind: 'sun'; towards: readonly number[] | null } // that casts shadows
  | { kind: 'hidden'; is_hidden: boolean } // the page is not seen
  | { kind: 'redraw'; count: number } // what was handed over is lost: mesh and tiles are to come again
  | { kind: 'reopen' } // connects anew, and resumes
  | { kind: 'save recording' }
  | SightMessage
  | { kind: 'close' }; // answered by 'closed'; a recording can still be saved

export type FromWorker =
  | { kind: 'closed' }
  | { kind: 'migrate' } // the server hands its viewers over: the connection is opened anew at once
  | { kind: 'ground'; id: number; ground: ExactGround } // the reply
  | { kind: 'open' } // a connection is open, and a session begins
  | { kind: 'waiting'; seconds: number; reason: string } // for the next attempt to connect; the reason is a sentence, or empty
  | { kind: 'refused'; reason: string } // the session has ended
  | { kind: 'welcome'; message: Uint8Array }
  | { kind: 'tour'; message: Uint8Array } // has come
  | { kind: 'mesh'; update: MeshUpdate }
  | { kind: 'redrawn'; count: number } // by that 'redraw': the next mesh needs nothing of those before
  | { kind: 'lines'; version: number; terrain: PartLines; objects: PartLines } // of a mesh that was sent without
  | { kind: 'recording'; file: Blob } // so far
  | { kind: 'damaged'; what: string } // the first tile that cannot be decoded
  | SightAnswer
  | { kind: 'failed'; failure: Failure } // nothing but a recording comes any more
  | { kind: 'state'; statistics: Statistics; is_open: boolean; area: number | null; ground: Uint8Array | null };
