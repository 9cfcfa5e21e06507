// Whether all controls in sight, or that scrolling brings there, can be reached: { count, wrong: [sentences] }.
const wrong = [];
const [wide, high] = [innerWidth, innerHeight];
const named = (e) => `${e.tagName.toLowerCase()} ${e.id || e.ariaLabel || e.textContent.trim().slice(0, 30)}`;

if (document.documentElement.scrollWidth > wide || document.body.scrollWidth > wide) wrong.push('the page is too wide');
for (const box of document.querySelectorAll('#panels, #panel, #main, #head, dialog[open]')) {
  if (box.scrollWidth > box.clientWidth + 1) wrong.push(`${named(box)}: ${box.scrollWidth} in ${box.clientWidth} px`);
}

const modal = document.querySelector('dialog[open]');
const controls = [...(modal ?? document).querySelectorAll('button, input, select, summary, [tabindex="0"], pre')];
const inSight = controls.filter((e) => e.checkVisibility({ visibilityProperty: true }) && !e.hidden);
for (const e of inSight) {
  if (e.closest('#panels')) e.scrollIntoView({ block: 'center' });
  const { left, right, top, bottom, width, height } = e.getBoundingClientRect();
  const what = `${named(e)} at ${[left, top, right, bottom].map(Math.round)}`;
  if (left < -0.5 || right > wide + 0.5 || width === 0) wrong.push(`${what}: not in sight`);
  const isLong = e.matches('pre');
  if (!isLong && (top < -0.5 || bottom > high + 0.5)) wrong.push(`${what}: cannot be scrolled to`);
  // Handles of the curve may lie on each other.
  if (isLong || e.closest('svg') || e.matches('canvas')) continue;
  const hit = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
  if (!hit || !(e.contains(hit) || hit.contains(e) || e.labels?.[0]?.contains(hit))) {
    wrong.push(`${what}: behind ${hit ? named(hit) : 'nothing'}`);
  }
  const isCut = e.matches('button, .number, .colour .text') && e.scrollWidth > e.clientWidth + 1;
  if (isCut) wrong.push(`${what}: its text is cut off`);
  // WCAG 2.2, 2.5.8.
  if (e.matches('button, select, .text, .number') && Math.min(width, height) < 24) wrong.push(`${what}: too small`);
}
document.getElementById('panels').scrollTop = 0;
return { count: inSight.length, wrong };
