// What can be taken along: commands, pictures, key frames and links.

const KEYFRAME_STEP = 24;
let keyframes = []; // {frame, view}
const job = (keyframes) => ({ ...subject(), samples: phalanx.frame?.samples ?? 1, keyframes });

function download(name, blob) {
  const link = element('a', { download: name, href: URL.createObjectURL(blob) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60e3);
}
// Shows the text in a field, and copies it; where the clipboard is denied, by the field's selection.
async function copy(text, what) {
  const field = Object.assign($('text'), { value: text, hidden: false });
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    field.select();
    if (!document.execCommand('copy')) return say(`${what}: press Ctrl+C to copy it.`);
  }
  say(`${what} copied.`);
}

async function copyCommand(sequence) {
  const command = await ask(server.command(job(sequence)));
  if (command) copy(command, sequence ? 'Command of the sequence' : 'Command');
}
async function save() {
  $('save').disabled = true;
  say('Rendering the picture to save…');
  const file = await ask(server.save(job(false)));
  $('save').disabled = false;
  if (!file) return;
  download(file.name, file.blob);
  say(`${file.name} saved.`);
}

function setKeyframes(changed) {
  keyframes = changed.sort((a, b) => a.frame - b.frame);
  const rows = keyframes.map((key, k) => {
    const label = (text) => ({ ariaLabel: `${text} view ${k + 1}` });
    const number = element('input', { type: 'number', min: 0, value: key.frame, ...label('Frame of') });
    number.onchange = () => {
      const frame = Math.max(0, Math.round(number.valueAsNumber) || 0);
      if (keyframes.every((other) => other.frame !== frame)) key.frame = frame;
      else say(`Frame ${frame} has a view already.`);
      setKeyframes(keyframes);
    };
    const go = element('button', { ...label('Go to'), onclick: () => move(key.view) }, 'Go to');
    const remove = element('button', label('Remove'), 'Remove');
    remove.onclick = () => setKeyframes(keyframes.filter((other) => other !== key));
    return element('li', {}, number, go, remove);
  });
  $('keyframes').replaceChildren(...rows);
  $('sequence').hidden = !rows.length;
}

const nextFrame = () => (keyframes.at(-1)?.frame ?? -KEYFRAME_STEP) + KEYFRAME_STEP;
const link = () => location.href.split('#')[0] + toFragment(app.view, app.mode);
// Keeps the address up to date; browsers allow a few changes a second.
function keepLink() {
  timers.link ||= setTimeout(() => {
    timers.link = 0;
    history.replaceState(null, '', link());
  }, 500);
}
