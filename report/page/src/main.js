// The page of `strake report`. Its data are in the element `data`, its arrays in the elements blob-*.

import './page.css';
import { h } from '../../../viewer/page/src/dom.js';
import { head, summary, failures, cost, theCase, evaluations } from './summary.js';
import { progress } from './charts.js';
import { shapes } from './shapes.js';
import { samples } from './samples.js';
import { tree } from './tree.js';
import { bodies } from './bodies.js';
import { wings } from './wings.js';

async function build() {
  const run = JSON.parse(document.getElementById('data').textContent);
  const page = document.getElementById('report');
  const shapePlace = h('div', {}), treePlace = h('div', {});
  page.append(head(run), summary(run), samples(run), progress(run), wings(run), bodies(run), shapePlace, treePlace, evaluations(run), failures(run), cost(run), theCase(run));
  const panel = await shapes(run, shapePlace);
  treePlace.append(tree(run, panel));
  document.documentElement.dataset.ready = panel ? 'shapes' : 'text';
  window.strakeReport = { run, panel };
}

build().catch((error) => {
  console.error(error);
  document.getElementById('report').append(h('p', { class: 'problem' }, `This page could not be built: ${error.message}`));
  document.documentElement.dataset.ready = 'failed';
});
