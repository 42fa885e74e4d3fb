// Makes the pictures of relief and imagery in the documents: a valley, the summit and the whole scene with imagery and without, and a strip
// of hours; and the one of the page in README. They are made by the page in headless Chromium. The programs are those of FORELAND_BIN
// (default build/release/bin), the page is dist/.
//
//   foreland synth --imagery msh.tif --over msh_base_utm10_10m.tif --imagery-detail 10
//   foreland build msh_base_utm10_10m.tif --imagery msh.tif -o msh.fls
//   node make_pictures.mjs msh.fls [NAME...]         writes docs/images/msh-NAME.jpg: valley, summit, scene, relief, hours
//   node make_pictures.mjs build/demo/SCENE.fls page  writes docs/images/page.jpg
//
// The views are those of Mount St. Helens (USGS, before 2004); that of the page is of the landscape that `./demo` makes.
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { openBrowser, openPage, root, startServer, status, until } from './tests/support.mjs';

const kEvening = { azimuth: 247, height: 21 };
// East and north of the scene's middle, height, heading, pitch; metres and degrees. `above`: the height is above the ground.
const kViews = {
  valley: { at: [-2100, 2600], above: 60, look: [163, -2], sun: { azimuth: 112, height: 24 } },
  summit: { at: [600, -2300], height: 2560, look: [188, -14], sun: kEvening },
  scene: { at: [3200, 9800], height: 5200, look: [197, -17], sun: kEvening },
  relief: { at: [600, -2300], height: 2560, look: [188, -14], sun: kEvening, more: 'imagery=0&ground=heights' },
};
// Of the page, which flies to its view from behind it.
const kPage = { at: [-9277, 1236], height: 3010, look: [55, -14], sun: { azimuth: 320, height: 22 }, tau: 1 };
const kPageFlight_m = 450;
// Of 21 September at 46 degrees north.
const kHours = [['7:00', 101, 10], ['10:00', 142, 37], ['15:00', 234, 29], ['17:30', 264, 5]];

function addressOf({ at, height, look, sun, tau = 0.7, more = '' }, server) {
  const light = `sun=free&azimuth=${sun.azimuth}&height=${sun.height}&shadows=1`;
  return new URL(`?sharpness=1&tau=${tau}&view=${[...at, height, ...look].join(',')}&${light}&${more}`, server.url).href;
}

// Nothing comes any more.
async function untilWhole(page) {
  let last = await until(page, (s) => s.triangles > 500 && s.relief_shown > 0, null, 240_000);
  for (let same = 0; same < 3;) {
    const now = await until(page, (s, n) => s.keyframes >= n, last.keyframes + 8, 240_000);
    const is_same = ['tiles_received', 'relief_shown', 'imagery_shown', 'nodes'].every((key) => now[key] === last[key]);
    same = is_same ? same + 1 : 0;
    last = now;
  }
  return last;
}

async function look(browser, server, view, size) {
  const { page, close } = await openPage(browser, { ...size, is_first_visit: true });
  try {
    if (view.above !== undefined) {
      await page.goto(addressOf({ ...view, height: 3000 }, server));
      const { above_ground_m } = await until(page, (s) => s.above_ground_m !== null && s.relief_shown > 3);
      view.height = 3000 - above_ground_m + view.above;
    }
    await page.goto(addressOf(view, server));
    await untilWhole(page);
    await page.evaluate(() => document.querySelectorAll('body > :not(canvas)').forEach((e) => e.toggleAttribute('hidden', true)));
    await page.evaluate(() => document.querySelectorAll('body > :not(canvas)').forEach((e) => (e.style.display = 'none')));
    const { frames } = await status(page);
    await until(page, (s, n) => s.frames > n + 2, frames);
    return await page.screenshot({ type: 'jpeg', quality: 84 });
  } finally {
    await close();
  }
}

// The page after a flight, as a person sees it, with its settings folded. The picture is drawn once the camera rests and all is there, and not
// again: drawn by a processor each frame would take half a second, and the read-out would say so. So it says what it says where a graphics
// card draws beside the page.
async function lookAtPage(browser, server, size) {
  const { page, close } = await openPage(browser, size);
  try {
    await page.addInitScript(drawOnDemand);
    await page.goto(addressOf(kPage, server));
    await page.locator('#panel .toggle').click();
    await page.evaluate(() => document.querySelector('#hint').toggleAttribute('hidden', true));
    const { eye } = await untilWhole(page);
    await page.locator('#scene').focus();
    await page.keyboard.down('KeyW');
    await until(page, (s, [from, metres]) => Math.hypot(...s.eye.map((v, i) => v - from[i])) > metres, [eye, kPageFlight_m]);
    await page.keyboard.up('KeyW');
    const { frames } = await untilWhole(page);
    await page.evaluate(() => (window.draws = true));
    const drawn = await until(page, (s, n) => s.frames > n, frames, 240_000);
    await page.evaluate(() => (window.draws = false));
    await until(page, (s, n) => s.frames > n + 120, drawn.frames); // over which the read-out averages
    return await page.screenshot({ type: 'jpeg', quality: 88 });
  } finally {
    await close();
  }
}

// In the page: the canvas is drawn on while window.draws is true. It keeps what was drawn last.
function drawOnDemand() {
  for (const name of ['clear', 'drawArrays', 'drawElements']) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...all) {
      if (window.draws) draw.apply(this, all);
    };
  }
}

// Pictures side by side, each with its words.
async function stripOf(browser, pictures, { width, height }) {
  const { page, close } = await openPage(browser, { width: 2 * width + 4, height: 2 * height + 4 });
  try {
    await page.setContent(`<body style="margin:0;display:grid;gap:4px;background:#fff;grid-template-columns:max-content max-content">${pictures.map(
      ({ words, data }) => `<div style="position:relative"><img style="display:block" src="data:image/jpeg;base64,${data.toString('base64')}">
      <b style="position:absolute;left:12px;bottom:9px;color:#fff;font:600 17px sans-serif;text-shadow:0 1px 4px #000">${words}</b></div>`).join('')}`);
    return await page.screenshot({ type: 'jpeg', quality: 82 });
  } finally {
    await close();
  }
}

const [scene, ...names] = process.argv.slice(2);
if (!scene) throw new Error('usage: node make_pictures.mjs SCENE.fls [NAME...]');
const wanted = names.length > 0 ? names : [...Object.keys(kViews), 'hours'];
const server = await startServer(scene);
const browser = await openBrowser();
try {
  for (const name of wanted) {
    let picture;
    if (name === 'hours') {
      const size = { width: 638, height: 358 };
      const pictures = [];
      for (const [words, azimuth, height] of kHours) {
        const view = { at: [-2600, 1500], height: 2300, look: [158, -8], sun: { azimuth, height } };
        pictures.push({ words, data: await look(browser, server, view, size) });
      }
      picture = await stripOf(browser, pictures, size);
    } else if (name === 'page') {
      picture = await lookAtPage(browser, server, { width: 1280, height: 720 });
    } else {
      picture = await look(browser, server, kViews[name], { width: 1280, height: 720 });
    }
    const file = name === 'page' ? 'page.jpg' : `msh-${name}.jpg`;
    await writeFile(join(root, 'docs/images', file), picture);
    console.log(`${file}: ${(picture.length / 1000).toFixed(0)} kB`);
  }
} finally {
  await browser.close();
  await server.stop();
}
