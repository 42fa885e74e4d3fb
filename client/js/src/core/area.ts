// The area of a large scene, as client/area.h counts them, in an address of viewers.
const kArea = 'area';

export function addressIn(url: string, area: number): string {
  const address = new URL(url);
  address.searchParams.set(kArea, String(area));
  return address.href;
}
