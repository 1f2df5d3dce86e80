// The studio without a network, and with threads from any static host: what was loaded once comes from
// the browser's cache when it cannot be loaded again, and every answer has the headers that let a page
// share memory between threads.
const CACHE = "cosplat-studio";

// All that the studio loads, by bundle.mjs.
async function load() {
  const files = await (await fetch("dist/studio-files.json")).json();
  await (await caches.open(CACHE)).addAll(files);
  await self.skipWaiting();
}
self.addEventListener("install", (event) => event.waitUntil(load()));
self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));

async function answer(request) {
  let response;
  try {
    response = await fetch(request);
    if (response.ok && response.status === 200) {
      const cache = await caches.open(CACHE);
      await cache.put(request, response.clone()).catch(() => {});  // a full storage costs that only
    }
  } catch (error) {
    response = await caches.match(request);
    if (!response) throw error;
  }
  const headers = new Headers(response.headers);
  headers.set("cross-origin-opener-policy", "same-origin");
  headers.set("cross-origin-embedder-policy", "require-corp");
  return new Response(response.body, { status: response.status, statusText: response.statusText, headers });
}

self.addEventListener("fetch", (event) => {
  const { request } = event;
  if (request.method === "GET" && new URL(request.url).origin === self.location.origin) event.respondWith(answer(request));
});
