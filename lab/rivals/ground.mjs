// The truth: heights of the scene's samples, as flight_plan.h writes them. Node and pages; pure but for `readGround`.

// `heights` row by row from the south. Places in radians; beyond the samples the nearest ones count.
export function groundOf(about, heights) {
  const { width, height, west_deg, south_deg, step_deg } = about, r = Math.PI / 180;
  const [west, south, dx, dy] = [west_deg * r, south_deg * r, step_deg[0] * r, step_deg[1] * r];
  const at = (i, j) => heights[j * width + i];
  const heightAt = (lon, lat) => {
    const x = Math.min(Math.max((lon - west) / dx, 0), width - 1), y = Math.min(Math.max((lat - south) / dy, 0), height - 1);
    const i = Math.min(Math.floor(x), width - 2), j = Math.min(Math.floor(y), height - 2), u = x - i, v = y - j;
    return (at(i, j) * (1 - u) + at(i + 1, j) * u) * (1 - v) + (at(i, j + 1) * (1 - u) + at(i + 1, j + 1) * u) * v;
  };
  // The sample that is nearest to a place: its place and height. Null beyond the data.
  const nearest = (lon, lat) => {
    const i = Math.round((lon - west) / dx), j = Math.round((lat - south) / dy);
    return i < 0 || j < 0 || i >= width || j >= height ? null : [west + i * dx, south + j * dy, at(i, j)];
  };
  return { width, height, west, south, east: west + (width - 1) * dx, north: south + (height - 1) * dy, dx, dy, heightAt, nearest };
}

export async function readGround(about) {
  const { readFile } = await import('node:fs/promises');
  const { buffer, byteOffset, byteLength } = await readFile(about.heights);
  return groundOf(about, new Float64Array(buffer.slice(byteOffset, byteOffset + byteLength)));
}
