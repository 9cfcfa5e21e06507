// The panel: its tabs, and the sheet that it is on a phone.
'use strict';

import { byId } from './dom.js';
import { say } from './store.js';

const names = ['colours', 'scene', 'probe', 'files'];
const tab = (name) => byId(`tab-${name}`);

/** Shows a tab of the panel, and the panel. */
export function openTab(name) {
  show(true);
  for (const other of names) {
    const isOpen = other === name;
    tab(other).setAttribute('aria-selected', String(isOpen));
    tab(other).tabIndex = isOpen ? 0 : -1;
    byId(`panel-${other}`).hidden = !isOpen;
  }
  byId('panels').scrollTop = 0;
}

/** Whether the panel is shown. */
export const isShown = () => !document.body.classList.contains('is-panel-hidden');

/** Shows or hides the panel. */
export function show(isOpen = !isShown()) {
  document.body.classList.toggle('is-panel-hidden', !isOpen);
  byId('toggle-panel').setAttribute('aria-expanded', String(isOpen));
}

/** Shows the picture alone on the whole screen, or the page again. */
export async function toggleFullScreen() {
  try {
    await (document.fullscreenElement ? document.exitFullscreen() : byId('main').requestFullscreen());
  } catch (error) {
    say(`The browser shows no full screen: ${error.message}`, 'error');
  }
}

/** Which tab is open. */
export const openName = () => names.find((name) => tab(name).getAttribute('aria-selected') === 'true');

/** Puts the focus on a tab by its number from 1. */
export function focusTab(number) {
  if (!names[number - 1]) return;
  openTab(names[number - 1]);
  tab(names[number - 1]).focus();
}

/** Listens to the tabs. */
export function start() {
  names.forEach((name, i) => {
    tab(name).addEventListener('click', () => {
      // On a phone a second touch folds the sheet.
      const isSame = openName() === name && isShown();
      if (isSame && matchMedia('(max-width: 760px)').matches) show(false);
      else openTab(name);
    });
    tab(name).addEventListener('keydown', (event) => {
      const to = { ArrowLeft: i - 1, ArrowRight: i + 1, Home: 0, End: names.length - 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      focusTab(((to + names.length) % names.length) + 1);
    });
  });
  byId('toggle-panel').addEventListener('click', () => show());
  byId('full-screen').addEventListener('click', toggleFullScreen);
  document.addEventListener('fullscreenchange', () =>
    byId('full-screen').setAttribute('aria-pressed', String(document.fullscreenElement !== null)),
  );
  const grip = byId('grip');
  let from = null;
  const set = (height) => {
    const most = window.innerHeight * 0.85;
    byId('panel').style.height = `${Math.min(most, Math.max(120, height))}px`;
  };
  grip.addEventListener('pointerdown', (event) => {
    from = { y: event.clientY, height: byId('panel').offsetHeight, isMoved: false };
    grip.setPointerCapture(event.pointerId);
  });
  grip.addEventListener('pointermove', (event) => {
    if (!from) return;
    from.isMoved ||= Math.abs(event.clientY - from.y) > 4;
    if (from.isMoved) {
      show(true);
      set(from.height + from.y - event.clientY);
    }
  });
  grip.addEventListener('pointerup', () => {
    if (from && !from.isMoved) show();
    from = null;
  });
  grip.addEventListener('keydown', (event) => {
    const step = { ArrowUp: 60, ArrowDown: -60 }[event.key];
    if (event.key === 'Enter' || event.key === ' ') show();
    else if (step) set(byId('panel').offsetHeight + step);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  if (matchMedia('(max-width: 760px)').matches) show(false);
}
