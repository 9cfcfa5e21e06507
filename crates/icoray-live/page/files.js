// Saving and loading: the scene, pictures, the command line.
'use strict';

import { file } from './api.js';
import { byId } from './dom.js';
import { save } from './format.js';
import { act } from './sender.js';
import { forgetHistograms, on, readScene, say, store } from './store.js';

/** Saves the scene as a TOML file. */
export async function saveScene() {
  try {
    await readScene();
    save(new Blob([store.scene.text], { type: 'application/toml' }), 'scene.toml');
    say('The scene is saved as scene.toml.');
  } catch (error) {
    say(error.message, 'error');
  }
}

async function savePicture(format, button) {
  button.disabled = true;
  say('The picture is rendered to the scene’s tolerance.');
  try {
    const found = await file(`/api/picture?format=${format}`);
    const name = found.name ?? `icoray.${format}`;
    save(found.blob, name);
    say(`The picture is saved as ${name}.`);
  } catch (error) {
    say(error.message, 'error');
  } finally {
    button.disabled = false;
    button.focus();
  }
}

async function load(input) {
  const [chosen] = input.files;
  if (!chosen) return;
  const text = await chosen.text();
  input.value = '';
  forgetHistograms();
  if (await act('/api/load', text)) say(`${chosen.name} is loaded.`);
}

async function copy() {
  const text = byId('command').textContent;
  try {
    await navigator.clipboard.writeText(text);
    say('The command is copied.');
  } catch {
    getSelection().selectAllChildren(byId('command'));
    say('The command is selected; copy it with Ctrl+C.');
  }
}

/** Listens to the buttons. */
export function start() {
  byId('save-scene').addEventListener('click', saveScene);
  byId('load-scene').addEventListener('click', () => byId('load-file').click());
  byId('load-file').addEventListener('change', (event) => load(event.target));
  byId('save-png').addEventListener('click', (event) => savePicture('png', event.currentTarget));
  byId('save-exr').addEventListener('click', (event) => savePicture('exr', event.currentTarget));
  byId('copy-command').addEventListener('click', copy);
  on('scene', (scene) => {
    byId('scene-text').textContent = scene.text;
    byId('command').textContent = scene.command ?? '';
    byId('command-part').hidden = !scene.command;
  });
}
