// Words of errors, as sentences.
export function sentenceOf(text: string): string {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}

export function reasonOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

export function metresText(metres: number): string {
  if (Math.abs(metres) >= 10000) return `${(metres / 1000).toFixed(1)} km`;
  const size = Math.abs(metres);
  return `${metres.toFixed(size < 0.1 && size > 0 ? 2 : size < 10 ? 1 : 0)} m`;
}
