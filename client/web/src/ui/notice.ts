// Messages over the scene: a passing state (connecting, reconnecting), or why the session ended and what to do.

export interface Notice {
  title: string;
  text: string;
  action?: { label: string; run: () => void };
  kind: 'wait' | 'error';
}

export function showNotice(root: HTMLElement, notice: Notice | null): void {
  root.hidden = notice === null;
  if (!notice) return root.replaceChildren();
  root.className = notice.kind;
  const title = Object.assign(document.createElement('strong'), { textContent: notice.title });
  const text = Object.assign(document.createElement('span'), { textContent: notice.text });
  root.replaceChildren(title, text);
  if (!notice.action) return;
  const button = Object.assign(document.createElement('button'), { type: 'button', textContent: notice.action.label });
  button.onclick = notice.action.run;
  root.append(button);
}
