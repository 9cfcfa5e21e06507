// Calls of the server. Each call carries the token, which the page takes from its address once, with what a link adds to it.
'use strict';

const KEY = 'icoray-live-token';
let token = '';

/** An answer with an error: its status (0: no answer) and its sentence. */
export class ApiError extends Error {
  constructor(status, message) {
    super(message);
    this.status = status;
  }
  /** Whether no program answered. */
  get isGone() {
    return this.status === 0;
  }
}

/** The address of this page, with texts by name that `takeAddress` returns where it is opened. */
export const addressOf = (texts) => `${location.origin}/#${[encodeURIComponent(token), new URLSearchParams(texts)].join('&')}`;

/**
 * Takes the token from the address and removes it there; a reload finds it in the session's storage. Returns the texts
 * that a link has beside it.
 */
export function takeAddress() {
  const [given, ...texts] = location.hash.slice(1).split('&');
  if (given) {
    token = decodeURIComponent(given);
    try {
      sessionStorage.setItem(KEY, token);
    } catch {
      /* The token is kept in memory only. */
    }
    history.replaceState(null, '', location.pathname + location.search);
  } else {
    try {
      token = sessionStorage.getItem(KEY) ?? '';
    } catch {
      token = '';
    }
  }
  // Another address in the same tab differs behind the # alone, for which browsers load nothing.
  addEventListener('hashchange', () => location.hash.length > 1 && location.reload());
  return Object.fromEntries(new URLSearchParams(texts.join('&')));
}

/** The response of a call; throws `ApiError` for any status but 2xx. */
export async function call(path, options = {}) {
  let response;
  try {
    const headers = { Authorization: `Bearer ${token}`, ...options.headers };
    response = await fetch(path, { cache: 'no-store', ...options, headers });
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new ApiError(0, 'The program that serves this page has ended.');
  }
  if (response.ok) return response;
  if (response.status === 401) {
    throw new ApiError(
      401,
      'This address lacks its token. Open the whole address that icoray printed, with what follows #.',
    );
  }
  let sentence = `The server answered ${response.status}.`;
  try {
    sentence = (await response.json()).error ?? sentence;
  } catch {
    /* An answer without JSON. */
  }
  throw new ApiError(response.status, sentence);
}

/** The body of a call, all of it; a connection that ends half way is an `ApiError` too. */
async function body(response, kind) {
  try {
    return await response[kind]();
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new ApiError(0, 'The program that serves this page has ended.');
  }
}

/** JSON of a GET call. */
export const get = async (path) => body(await call(path), 'json');

/** Bytes of a GET call, or null for 204. */
export async function bytes(path, options) {
  const response = await call(path, options);
  return response.status === 204 ? null : body(response, 'arrayBuffer');
}

/** A file of a GET call: its blob and the name the server gives. */
export async function file(path) {
  const response = await call(path);
  const name = /filename="?([^";]+)"?/.exec(response.headers.get('Content-Disposition') ?? '')?.[1];
  return { blob: await body(response, 'blob'), name };
}

/** JSON of a POST call with a JSON or text body. */
export async function post(path, value) {
  const isText = typeof value === 'string';
  const headers = { 'Content-Type': isText ? 'text/plain; charset=utf-8' : 'application/json' };
  const response = await call(path, { method: 'POST', headers, body: isText ? value : JSON.stringify(value ?? {}) });
  return body(response, 'json');
}
