// Swatches of all colour maps.
'use strict';

import { gradient } from './colour.js';
import { h } from './dom.js';

/** Builds the list of swatches; `choose(name)` is called with a map's name. */
export function makeSwatches(choose) {
  const list = h('div', { class: 'swatches', role: 'radiogroup', 'aria-label': 'Colour map' });
  const search = h('input', {
    type: 'search',
    class: 'text',
    placeholder: 'Find a map',
    'aria-label': 'Find a colour map',
    oninput: () => filter(),
  });
  const element = h('div', { class: 'maps' }, search, list);
  let swatches = [];
  let chosen = '';
  let shownFor = null;

  const visible = () => swatches.filter((swatch) => !swatch.hidden);

  function filter() {
    const text = search.value.trim().toLowerCase();
    for (const swatch of swatches) swatch.hidden = !swatch.dataset.name.includes(text);
    tabStop();
  }

  function tabStop() {
    const seen = visible();
    const stop = seen.find((swatch) => swatch.dataset.name === chosen) ?? seen[0];
    for (const swatch of swatches) swatch.tabIndex = swatch === stop ? 0 : -1;
  }

  function keys(event) {
    const seen = visible();
    const columns = Math.max(1, Math.round(list.clientWidth / (seen[0]?.offsetWidth + 4 || 1)));
    const step = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -columns, ArrowDown: columns }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const next = seen[seen.indexOf(event.target.closest('.swatch')) + step];
    if (!next) return;
    next.focus();
    choose(next.dataset.map);
  }

  list.addEventListener('keydown', keys);

  return {
    element,
    /** Shows the maps of the description, with the one chosen marked. */
    show(maps, name) {
      if (shownFor?.length !== maps.length) {
        shownFor = maps;
        swatches = maps.map((map) => {
          const strip = h('span', { class: 'strip' });
          strip.style.backgroundImage = gradient(map.colors);
          return h(
            'button',
            {
              type: 'button',
              class: 'swatch',
              role: 'radio',
              tabindex: -1,
              'data-name': map.name.toLowerCase(),
              'data-map': map.name,
              title: map.name,
              onclick: () => choose(map.name),
            },
            strip,
            h('span', { class: 'swatch-name' }, map.name),
          );
        });
        list.replaceChildren(...swatches);
        filter();
      }
      const lower = name.toLowerCase();
      chosen = maps.some((map) => map.name.toLowerCase() === lower) ? lower : lower.replace(/_r$/, '');
      for (const swatch of swatches) swatch.setAttribute('aria-checked', String(swatch.dataset.name === chosen));
      tabStop();
    },
  };
}
