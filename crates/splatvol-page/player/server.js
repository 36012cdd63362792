// The server that a page comes from: only such pages have this.

/** A server that answers as an instance does. What is asked later may be answered first. */
function onServer() {
  const name = Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  const headers = { "X-Splatvol-Client": name };
  const answered = async (response) => {
    if (!response.ok) throw new Error((await response.text()).trim() || response.statusText);
    return response;
  };
  /** What is asked of the network, unless it was left on purpose, or says why it does not come. */
  const arrived = (asked) => asked.catch((error) => {
    if (error.name === "AbortError") throw error;
    throw new Error(`the server does not answer: it has ended, or the connection to it is lost (${error.message})`);
  });
  let controller = new AbortController();
  return {
    facts: async () => (await answered(await arrived(fetch("facts", { headers })))).json(),
    async ask(header) {
      const start = performance.now();
      const { signal } = header.do === "render" ? controller : {};
      const asked = { method: "POST", headers: { ...headers, "Content-Type": "application/json" }, body: JSON.stringify(header), signal };
      const response = await answered(await arrived(fetch("ask", asked)));
      const buffer = await arrived(response.arrayBuffer());
      const view = new DataView(buffer);
      const [said, pixels] = [view.getUint32(0, true), view.getUint32(4, true)];
      return {
        header: JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, said))),
        bytes: new Uint8Array(buffer, 8 + said, pixels),
        milliseconds: performance.now() - start,
      };
    },
    /** Leaves the picture that is being made: the server stops it. */
    stop() {
      controller.abort();
      controller = new AbortController();
    },
  };
}

/** The same of a page from a server; without instances where the page or the browser has none. */
async function startServed(page) {
  const server = onServer();
  const facts = await server.facts();
  const none = { pool: { members: [], workers: 0 } };
  const { pool, scene } = $("engine").textContent === "" ? none : await startInstances(page).catch(() => none);
  return { pool: { ...pool, server }, facts, scene };
}
