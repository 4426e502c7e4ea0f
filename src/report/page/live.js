// The live view: messages of the server, and the stop button. `handlers` receive the data of each kind of message; the
// last one is `end`.
'use strict';

function followLive(handlers) {
  const form = document.getElementById('live'), note = document.getElementById('live-note');
  const token = document.getElementById('live-token');
  form.hidden = false;
  const source = new EventSource('events');
  source.onopen = () => { note.textContent = 'live'; };
  source.onerror = () => { note.textContent = 'connection lost, trying again'; };
  for (const [kind, handle] of Object.entries(handlers))
    source.addEventListener(kind, (message) => {
      if (kind === 'end') {
        source.close();
        form.hidden = true;
      }
      handle(JSON.parse(message.data));
    });
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    fetch('stop', {method: 'POST', headers: {'X-Stop-Token': token.value.trim()}})
        .then((answer) => answer.text())
        .then((text) => { note.textContent = text.trim(); })
        .catch(() => { note.textContent = 'the stop was not received'; });
  });
}
