// The text of a file of features, which may be packed and in an old encoding. Whatever is in it is a stranger's. Pure.
import { unzipSync } from 'fflate';
import { kOverlayFiles } from './file_kinds';

export interface FileText {
  text: string;
  notes: string[];
}

// An Error says what is wrong with the file, by its name.
export function textOf(name: string, bytes: Uint8Array): FileText {
  const { max_bytes } = kOverlayFiles;
  if (bytes.length > max_bytes) throw new Error(`${name} has more than ${max_bytes >> 20} MB: leave something out, or simplify it, as by ogr2ogr -simplify.`);
  const is_packed = bytes[0] === 0x50 && bytes[1] === 0x4b; // "PK"
  return decoded(name, is_packed ? unpacked(name, bytes) : bytes);
}

// The first .kml of a KMZ. What it says of its size is an upper bound of what it takes: a longer one is cut off there, and is no XML.
function unpacked(name: string, bytes: Uint8Array): Uint8Array {
  let found = '', too_large = '';
  const filter = (file: { name: string; originalSize: number }) => {
    if (found !== '' || !/\.kml$/i.test(file.name)) return false;
    found = file.name.slice(0, 100);
    if (file.originalSize > kOverlayFiles.max_bytes) too_large = `${name}: ${found} in it has more than ${kOverlayFiles.max_bytes >> 20} MB.`;
    return too_large === '';
  };
  let files: Record<string, Uint8Array> = {};
  try {
    files = unzipSync(bytes, { filter });
  } catch (error) {
    throw new Error(`${name} cannot be unpacked: ${error instanceof Error ? error.message : error}. Save it again as KML.`);
  }
  if (too_large !== '') throw new Error(too_large);
  const file = Object.values(files)[0];
  if (!file) throw new Error(`${name} has no .kml in it.`);
  return file;
}

function decoded(name: string, bytes: Uint8Array): FileText {
  const head = new TextDecoder('latin1').decode(bytes.subarray(0, 200));
  const stated = head.startsWith('\u00ff\u00fe') ? 'utf-16le' : head.startsWith('\u00fe\u00ff') ? 'utf-16be' : /^[^<]*<\?xml[^>]*\bencoding=["']([\w.:-]+)["']/.exec(head)?.[1] ?? 'utf-8';
  try {
    return { text: new TextDecoder(stated, { fatal: true }).decode(bytes), notes: [] };
  } catch {
    // Neither what it says nor UTF-8: most such files are of Windows.
    return { text: new TextDecoder('windows-1252').decode(bytes), notes: [`${name} is not ${stated.toUpperCase()}; it was read as Latin-1 (Windows-1252).`] };
  }
}
