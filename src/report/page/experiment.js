// The page of an experiment: heights, runs, costs. Uses `experiment`, its data.
'use strict';

function fillHeights(data) {
  const most = Math.max(1, ...data.heights);
  $('stages').replaceChildren(...data.heights.map((count, height) => {
    const row = make('div', undefined, 'bar'), track = make('div'), bar = make('i');
    bar.style.width = `${100 * count / most}%`;
    track.append(bar);
    row.append(make('span', `height ${height}`), track, make('b', `${count}`));
    return row;
  }).reverse());
  $('stages').append(make('p', 'Runs by height in the true world. By the paper’s protocol: ' +
      data.paper_heights.map((count, height) => `${count} of height ${height}`).join(', ') + '.', 'hint'));
}

function fillRuns(data) {
  const table = $('runs'), head = make('tr'), body = make('tbody');
  head.append(...['run', 'seed', 'height', 'reported', 'paper’s protocol', 'robot s', 'end'].map((text) => make('th', text)));
  data.runs.forEach((run) => {
    const row = make('tr', undefined, run.height < run.reported ? 'bad' : '');
    row.append(...[run.run, run.seed, run.height, run.reported, run.paper_height, run.seconds.toFixed(0), run.ended].map(
        (text) => make('td', `${text}`)));
    body.append(row);
  });
  table.replaceChildren(head, body);
}

function showExperiment(data) {
  document.title = $('title').textContent = `${data.runs.length} of ${data.total} runs, mean height ${data.mean_height.toFixed(2)}`;
  $('subtitle').textContent = data.title;
  fillHeights(data);
  fillRuns(data);
  $('costs').innerHTML = data.figure5;
  $('summary').textContent = data.table;
}
showExperiment(experiment);
if (experiment.live) followLive({state: showExperiment, end: showExperiment});
document.documentElement.dataset.ready = 'true';
