// Sharing what is seen: a link that leads here, and a frame for another page.
import { boundTo, element, Form } from './form';
import { said } from './language';

const kFrames = { small: [640, 360], medium: [960, 540], large: [1280, 720] } as const;
type FrameSize = keyof typeof kFrames;

export class ShareControl {
  private readonly choice = { size: 'medium' as FrameSize };
  private readonly link = Object.assign(document.createElement('input'), { type: 'text', readOnly: true, name: 'share_link', ariaLabel: 'Link to what is seen' });
  private readonly frame = Object.assign(document.createElement('textarea'), { readOnly: true, rows: 4, name: 'share_frame', ariaLabel: 'Frame for another page' });
  private readonly button: HTMLButtonElement;

  // `linkHere` leads to what is seen; `needs_token`: a token beside it.
  constructor(tools: HTMLElement, private readonly card: HTMLElement, private readonly linkHere: () => string, needs_token: boolean, private readonly say: (text: string) => void) {
    this.button = buttonOf('Share', 'share', () => this.open(this.card.hidden === true));
    this.button.title = 'A link to what is seen, and a frame for another page';
    this.button.setAttribute('aria-pressed', 'false');
    tools.append(this.button);
    const header = document.createElement('header'), rows = element('div', 'rows'), close = buttonOf('\u00d7', 'share_close', () => this.open(false));
    close.ariaLabel = 'Close sharing';
    header.append(Object.assign(document.createElement('strong'), { textContent: 'Share' }), close);
    rows.append(this.link, buttonOf('Copy the link', 'copy_link', () => void this.copy(this.link, 'The link')));
    if (needs_token) rows.append(help('The link has no token: whoever opens it needs one.'));
    const form = new Form(() => this.show());
    form.select(rows, 'Frame', 'frame_size', Object.keys(kFrames) as FrameSize[], Object.values(kFrames).map((size) => size.join(' \u00d7 ')), boundTo(this.choice, 'size'));
    rows.append(this.frame, buttonOf('Copy the frame', 'copy_frame', () => void this.copy(this.frame, 'The frame')),
      help('A server lets pages of its own origin frame this one. For others, let its proxy replace frame-ancestors.'));
    card.append(header, rows);
  }

  private open(is_open: boolean): void {
    this.card.hidden = !is_open;
    this.button.setAttribute('aria-pressed', String(is_open));
    if (is_open) this.show();
  }
  private show(): void {
    const link = this.linkHere(), [width, height] = kFrames[this.choice.size];
    this.link.value = link;
    this.frame.value = `<iframe src="${link.replaceAll('&', '&amp;').replaceAll('"', '%22')}" width="${width}" height="${height}" title="Terrain" style="border:0" allow="fullscreen" loading="lazy"></iframe>`;
  }

  // What is seen by now.
  private async copy(field: HTMLInputElement | HTMLTextAreaElement, what: string): Promise<void> {
    this.show();
    field.select();
    try {
      await navigator.clipboard.writeText(field.value);
      this.say(`${what} is copied.`);
    } catch {
      this.say(`${what} is selected: copy it by Ctrl+C.`); // where a page may not write the clipboard, as without TLS
    }
  }
}

function help(text: string): HTMLElement {
  return Object.assign(element('p', 'help'), { textContent: said(text) });
}
function buttonOf(text: string, name: string, run: () => void): HTMLButtonElement {
  const button = Object.assign(document.createElement('button'), { type: 'button' as const, name, textContent: said(text) });
  button.onclick = run;
  return button;
}
