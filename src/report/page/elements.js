// Short names for the elements of a page. Shared by all pages.
'use strict';

const $ = (id) => document.getElementById(id);
const make = (tag, text, name) => {
  const element = document.createElement(tag);
  if (text !== undefined) element.textContent = text;
  if (name) element.className = name;
  return element;
};

// A box that shows or hides a group of the scene; `colour`: that of its lines, for a legend.
function addLayer(name, text, group, shown, render, colour) {
  const label = make('label'), box = make('input');
  box.type = 'checkbox';
  box.id = `layer-${name}`;
  box.checked = group.visible = shown;
  box.addEventListener('change', () => { group.visible = box.checked; render(); });
  label.append(box);
  if (colour) label.append(Object.assign(make('i', undefined, 'swatch'), {style: `background:${colour}`}));
  label.append(` ${text}`);
  $('layers').append(label);
}
