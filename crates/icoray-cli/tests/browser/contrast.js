// Contrast of all text in sight, as WCAG 2.2 has it (1.4.3): { count, worst, low: [what is below 4.5 to 1] }.
const LEAST = 4.5;

const parse = (css) => {
  const [r, g, b, a = 1] = css.match(/[\d.]+/g).map(Number);
  return { rgb: [r, g, b], a };
};
const over = (top, a, below) => top.map((c, i) => c * a + below[i] * (1 - a));
const luminance = (rgb) =>
  rgb
    .map((c) => c / 255)
    .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
const ratio = (a, b) => {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (high + 0.05) / (low + 0.05);
};

// The colours of a text and of what is behind it, over a picture of one colour.
const seen = (element, css, picture) => {
  let ground = [0, 0, 0];
  const faded = [];
  const chain = [];
  for (let e = element; e; e = e.parentElement) chain.unshift(e);
  for (const e of chain) {
    const style = getComputedStyle(e);
    if (Number(style.opacity) < 1) faded.push({ part: Number(style.opacity), behind: ground });
    const { rgb, a } = parse(style.backgroundColor);
    ground = over(rgb, a, ground);
    if (e.id === 'stage') ground = picture;
  }
  const { rgb, a } = parse(css);
  let text = over(rgb, a, ground);
  for (const { part, behind } of faded.reverse()) {
    text = over(text, part, behind);
    ground = over(ground, part, behind);
  }
  return [text, ground];
};

const found = { count: 0, worst: Infinity, low: [] };
const check = (element, css, text) => {
  // WCAG exempts what is switched off.
  if (element.closest(':disabled, [hidden], noscript')) return;
  if (!element.checkVisibility({ visibilityProperty: true })) return;
  const pictures = element.closest('#stage') ? [[0, 0, 0], [255, 255, 255]] : [[0, 0, 0]];
  const least = Math.min(...pictures.map((picture) => ratio(...seen(element, css, picture))));
  found.count += 1;
  found.worst = Math.min(found.worst, least);
  if (!(least >= LEAST)) found.low.push(`${least.toFixed(2)}: ${text.trim().slice(0, 40)}`);
};

const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (texts.nextNode()) {
  const [text, element] = [texts.currentNode.data, texts.currentNode.parentElement];
  if (!text.trim() || element.closest('script, style, option')) continue;
  const style = getComputedStyle(element);
  check(element, element.namespaceURI.endsWith('svg') ? style.fill : style.color, text);
}
for (const input of document.querySelectorAll('input:not([type=range], [type=checkbox], [type=radio], [type=color])')) {
  check(input, getComputedStyle(input).color, input.value || 'input');
  if (input.placeholder) check(input, getComputedStyle(input, '::placeholder').color, input.placeholder);
}
for (const select of document.querySelectorAll('select')) check(select, getComputedStyle(select).color, select.value);
return found;
