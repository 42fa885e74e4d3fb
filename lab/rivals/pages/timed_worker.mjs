// The client's worker, which says of each mesh when it was made (worker_times.mjs).
import './worker_times.mjs';
import '/client/worker.js';
