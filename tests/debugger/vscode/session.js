// A session of VS Code's own test client with `emulator dap`: node session.js EMULATOR PROGRAM. Exit status 1 and the reason when something is not as expected.
const assert = require("node:assert");
const { DebugClient } = require("@vscode/debugadapter-testsupport");

async function main(emulator, program) {
  const client = new DebugClient(emulator, "dap", "c40", { env: process.env }, true);
  // The client starts `node ADAPTER`; ours is no script.
  const { spawn } = require("node:child_process");
  const adapter = spawn(emulator, ["dap"], { stdio: ["pipe", "pipe", "inherit"] });
  client.connect(adapter.stdout, adapter.stdin);
  client.defaultTimeout = 60000;
  try {
    const capabilities = (await client.initializeRequest()).body;
    assert(capabilities.supportsStepBack && capabilities.supportsDisassembleRequest && capabilities.supportsDataBreakpoints);
    const line = require("node:fs").readFileSync(program, "utf8").split("\n").findIndex((text) => text.includes("sti     r1")) + 1;
    await Promise.all([client.waitForEvent("initialized"), client.launchRequest({ program, stopAtEnd: true })]);
    const set = await client.setBreakpointsRequest({ source: { path: program }, breakpoints: [{ line }] });
    assert(set.body.breakpoints[0].verified && set.body.breakpoints[0].line === line);
    let stop;
    [stop] = await Promise.all([client.waitForEvent("stopped"), client.configurationDoneRequest()]);
    assert.equal(stop.body.reason, "breakpoint");
    assert.equal(stop.body.allThreadsStopped, true);
    const sums = [];
    for (let i = 0; i < 3; ++i) {
      const trace = await client.stackTraceRequest({ threadId: 1 });
      assert.equal(trace.body.stackFrames[0].line, line);
      const value = await client.evaluateRequest({ expression: "r1", frameId: trace.body.stackFrames[0].id, context: "hover" });
      sums.push(parseInt(value.body.result, 10));
      [stop] = await Promise.all([client.waitForEvent("stopped"), client.continueRequest({ threadId: 1 })]);
    }
    assert.deepEqual(sums, [5, 9, 12]);
    [stop] = await Promise.all([client.waitForEvent("stopped"), client.reverseContinueRequest({ threadId: 1 })]);
    const back = await client.evaluateRequest({ expression: "r1" });
    assert.equal(parseInt(back.body.result, 10), 12);
    [stop] = await Promise.all([client.waitForEvent("stopped"), client.stepBackRequest({ threadId: 1 })]);
    assert.equal(stop.body.reason, "step");
    const threads = await client.threadsRequest();
    assert.equal(threads.body.threads.length, 1);
    await client.disconnectRequest();
  } finally {
    adapter.kill();
  }
}

main(process.argv[2], process.argv[3]).then(
  () => process.exit(0),
  (error) => {
    console.error(error);
    process.exit(1);
  },
);
