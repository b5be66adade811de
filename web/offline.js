// SPDX-License-Identifier: Apache-2.0
// Keeps every file of the site, so that it works without a network. tools/website.py fills in the names.

const CACHE = "mmcs VERSION";
const FILES = "FILES";

const worker = /** @type {any} */ (self);
worker.addEventListener("install", event => {
  event.waitUntil(caches.open(CACHE).then(cache => cache.addAll(FILES)));
  worker.skipWaiting();
});
worker.addEventListener("activate", event => {
  const old = names => Promise.all(names.filter(n => n !== CACHE).map(n => caches.delete(n)));
  event.waitUntil(caches.keys().then(old).then(() => worker.clients.claim()));
});
worker.addEventListener("fetch", event => {
  const kept = caches.match(event.request, { ignoreSearch: true });
  event.respondWith(kept.then(found => found ?? fetch(event.request)));
});
