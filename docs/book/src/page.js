// Typesets code between dollars, $`a^2`$, as a formula; one that is a paragraph of its own is
// displayed. What is included from sources loses the indentation that it has there.
for (const code of document.querySelectorAll('code')) {
  const [before, after] = [code.previousSibling, code.nextSibling];
  if (!(before?.data?.endsWith('$') && after?.data?.startsWith('$'))) continue;
  [before.data, after.data] = [before.data.slice(0, -1), after.data.slice(1)];
  const around = code.parentElement;
  const displayMode = around.tagName === 'P' && around.textContent.trim() === code.textContent.trim();
  const formula = document.createElement('span');
  katex.render(code.textContent, formula, { displayMode });
  code.replaceWith(formula);
}
for (const code of document.querySelectorAll('pre > code')) {
  const indents = code.textContent.match(/^ *(?=\S)/gm) ?? [''];
  const least = Math.min(...indents.map((indent) => indent.length));
  code.innerHTML = code.innerHTML.replace(new RegExp(`^ {${least}}`, 'gm'), '');
}
