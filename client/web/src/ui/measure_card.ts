// The card of measurements: numbers in words, the profile, and what can be done with them.
import type { Scene } from '@foreland/client';
import type { Dates } from '../measure/change';
import type { Measurement } from '../measure/measurement';
import { areaText, heightText, lengthText, volumeText, type Units } from '../measure/units';
import { said } from './language';
import { ProfilePlot } from './profile_plot';
import { isRemembered, remember } from './remembered';
import { dateText } from './scene_time';

export interface MeasureCardActions {
  point(index: number | null): void; // a place of the profile
  compare(): void; // with another date
  save(kind: 'csv' | 'geojson'): void;
  cut(): void; // along it
  clear(): void;
  close(): void;
}

export class MeasureCard {
  private readonly rows = document.createElement('dl');
  private readonly how = Object.assign(document.createElement('p'), { className: 'help' });
  private readonly since = Object.assign(document.createElement('select'), { name: 'measure_since', ariaLabel: 'Compare with the ground of', hidden: true }); // dates of a scene that changes
  private readonly plot: ProfilePlot;
  private readonly buttons: Record<'csv' | 'geojson' | 'cut' | 'clear', HTMLButtonElement>;
  private readonly unit_button: HTMLButtonElement;
  private units: Units = isRemembered('imperial') ? 'imperial' : 'metric';
  private shown: Measurement | null = null;
  private scene: Scene | null = null;

  constructor(private readonly root: HTMLElement, actions: MeasureCardActions) {
    this.plot = new ProfilePlot((index) => actions.point(index));
    this.unit_button = buttonOf('', 'units', () => this.turnUnits());
    this.buttons = {
      csv: buttonOf('CSV', 'measure_csv', () => actions.save('csv')),
      geojson: buttonOf('GeoJSON', 'measure_geojson', () => actions.save('geojson')),
      cut: buttonOf('Cut', 'measure_cut', () => actions.cut()),
      clear: buttonOf('Clear', 'measure_clear', () => actions.clear()),
    };
    const header = document.createElement('header'), footer = document.createElement('footer');
    const close = buttonOf('\u00d7', 'measure_close', () => actions.close());
    close.ariaLabel = 'End measuring';
    header.append(Object.assign(document.createElement('strong'), { textContent: said('Measure') }), this.unit_button, close);
    footer.append(...Object.values(this.buttons));
    this.since.onchange = () => actions.compare();
    root.append(header, this.how, this.rows, this.since, this.plot.element, footer);
  }

  set isShown(is_shown: boolean) {
    this.root.hidden = !is_shown;
  }

  // Between which an area's change is measured: from the one that is chosen, first the first, to what is shown. Null: the scene does not change.
  datesOf({ epochs }: Scene, shown_ms: number): Dates | null {
    if (epochs.length < 2) return null;
    if (this.since.length !== epochs.length) this.since.replaceChildren(...epochs.map((ms) => new Option(`Since ${dateText(ms)}`, String(ms))));
    return { since_ms: Number(this.since.value), until_ms: shown_ms };
  }

  show(measurement: Measurement | null, scene: Scene, is_coming: boolean): void {
    [this.shown, this.scene] = [measurement, scene];
    const count = measurement?.corners.length ?? 0;
    this.how.textContent = is_coming ? 'The ground there is asked for\u2026'
      : count === 0 ? 'Click the ground; or press Enter for what is in the middle.'
      : count === 1 ? 'Click on for a line.' : count === 2 ? 'Click on for a longer line, or an area. Backspace takes a corner back.' : 'Backspace takes a corner back.';
    this.rows.replaceChildren(...rowsOf(measurement, scene, this.units).flatMap(([name, text]) => [
      Object.assign(document.createElement('dt'), { textContent: name }), Object.assign(document.createElement('dd'), { textContent: said(text) })]));
    this.since.hidden = !measurement?.change;
    this.plot.show(measurement?.profile ?? null, this.units);
    for (const button of Object.values(this.buttons)) button.disabled = count === 0;
    this.buttons.csv.disabled = this.buttons.cut.disabled = !measurement?.profile;
    this.unit_button.textContent = this.units === 'metric' ? 'm' : 'ft';
    this.unit_button.ariaLabel = `Units: ${this.units}`;
  }

  private turnUnits(): void {
    this.units = this.units === 'metric' ? 'imperial' : 'metric';
    remember('imperial', this.units === 'imperial');
    if (this.scene) this.show(this.shown, this.scene, false);
  }
}

function rowsOf(m: Measurement | null, scene: Scene, units: Units): [string, string][] {
  if (!m) return [];
  return m.corners.length === 1 ? rowsOfPoint(m, scene, units) : rowsOfLine(m, units);
}

function rowsOfPoint({ corners: [at], heights: [ground], slope }: Measurement, scene: Scene, units: Units): [string, string][] {
  const rows: [string, string][] = [['Place', 'lat' in at! ? `${at.lat.toFixed(6)}\u00b0, ${at.lon.toFixed(6)}\u00b0` : `${at!.easting.toFixed(2)} E, ${at!.northing.toFixed(2)} N`]];
  if (!Number.isFinite(ground!.height)) return [...rows, ['Height', 'beyond the data']];
  if (ground!.aboveSea !== null) rows.push(['Above the sea', heightText(ground!.aboveSea, units)]);
  if (ground!.aboveEllipsoid !== null) rows.push(['Above the ellipsoid', heightText(ground!.aboveEllipsoid, units)]);
  if (scene.vertical.above === 'unstated') rows.push(['Height', heightText(ground!.height, units)]);
  if (slope) rows.push(['Slope', degreesText(slope.slope_rad)]);
  if (slope && slope.aspect_rad !== null) rows.push(['Falls towards', `${degreesText(slope.aspect_rad)} ${windOf(slope.aspect_rad)}`]);
  return rows;
}

function rowsOfLine({ heights, profile, straight_m, area, change }: Measurement, units: Units): [string, string][] {
  const p = profile!, climb = heights[heights.length - 1]!.height - heights[0]!.height;
  const rows: [string, string][] = [
    ['Length', lengthText(p.length_m, units)], ['Along the ground', lengthText(p.surface_m, units)], ['Straight', lengthText(straight_m, units)],
    ['Height difference', Number.isFinite(climb) ? heightText(climb, units) : 'beyond the data'],
    ['Up and down', `${heightText(p.rise_m, units)}, ${heightText(p.fall_m, units)}`], ['Steepest', degreesText(p.steepest_rad)],
  ];
  if (!area) return rows;
  rows.push(['Area', areaText(area.plane_m2, units)], ['On the slope', areaText(area.slope_m2, units)],
    ['Above its plane', volumeText(area.above_m3, units)], ['Missing below', volumeText(area.below_m3, units)]);
  if (change) rows.push([`Gained until ${dateText(change.until_ms)}`, volumeText(change.gained_m3, units)], ['Lost', volumeText(change.lost_m3, units)]);
  return rows;
}

function degreesText(radians: number): string {
  return `${((radians * 180) / Math.PI).toFixed(1)}\u00b0`;
}
function windOf(radians: number): string {
  return ['N', 'NE', 'E', 'SE', 'S', 'SW', 'W', 'NW'][Math.round((radians * 4) / Math.PI) % 8]!;
}

function buttonOf(text: string, name: string, run: () => void): HTMLButtonElement {
  const button = Object.assign(document.createElement('button'), { type: 'button' as const, name, textContent: said(text) });
  button.onclick = run;
  return button;
}
