// Processor time that this process's children have taken, and theirs: by program, of browsers by process and thread. Seconds, of Linux's
// ten milliseconds each. Threads that have ended are left out.
import { readFile, readdir } from 'node:fs/promises';

const kTick_s = 0.01;
const read = (path) => readFile(path, 'utf8').catch(() => '');
// Of /proc/PID/stat: the name in brackets may hold anything.
function fieldsOf(stat) {
  const end = stat.lastIndexOf(')'), rest = stat.slice(end + 2).split(' ');
  return { name: stat.slice(stat.indexOf('(') + 1, end), parent: Number(rest[1]), seconds: kTick_s * (Number(rest[11]) + Number(rest[12])) };
}

async function descendants() {
  const parents = new Map();
  for (const pid of (await readdir('/proc')).filter((name) => /^\d+$/.test(name)).map(Number)) {
    const stat = await read(`/proc/${pid}/stat`);
    if (stat) parents.set(pid, fieldsOf(stat).parent);
  }
  const isOurs = (pid) => { for (; pid > 1; pid = parents.get(pid) ?? 0) if (pid === process.pid) return true; return false; };
  return [...parents.keys()].filter(isOurs);
}

export async function processorTimes() {
  const seconds = {};
  for (const pid of await descendants()) {
    const command = (await read(`/proc/${pid}/cmdline`)).split(/[\0 ]/), kind = command.find((word) => word.startsWith('--type='))?.slice(7);
    const program = kind ?? command[0].split('/').at(-1);
    for (const tid of await readdir(`/proc/${pid}/task`).catch(() => [])) {
      const stat = await read(`/proc/${pid}/task/${tid}/stat`);
      if (!stat) continue;
      const { name, seconds: taken } = fieldsOf(stat), key = kind ? `${program} ${Number(tid) === pid ? 'main' : name}` : program;
      seconds[key] = (seconds[key] ?? 0) + taken;
    }
  }
  return seconds;
}

// What was taken between two calls, of all that took at least a hundredth of the most.
export function between(before, after) {
  const taken = Object.entries(after).map(([key, seconds]) => [key, seconds - (before[key] ?? 0)]), most = Math.max(...taken.map(([, seconds]) => seconds));
  return Object.fromEntries(taken.filter(([, s]) => s >= 0.01 * most).sort((a, b) => b[1] - a[1]).map(([key, s]) => [key, Math.round(100 * s) / 100]));
}
