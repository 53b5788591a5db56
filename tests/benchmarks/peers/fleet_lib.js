// Virtual AGVs of vda-5050-lib for `tests.benchmarks fleet`, all in one process; N and the broker's URL.
const { AgvController, VirtualAgvAdapter } = require("vda-5050-lib");
const readline = require("readline");
const [size, url] = [Number(process.argv[2]), process.argv[3]];
const controllers = [];
console.log("standing");
const open = async () => {
  for (let n = 0; n < size; n++) {
    const agv = { manufacturer: "Woosh", serialNumber: `v${n}` };
    const controller = new AgvController(agv,
      { interfaceName: "uagv", transport: { brokerUrl: url, connectTimeout: 20000 }, vdaVersion: "2.0.0" },
      { agvAdapterType: VirtualAgvAdapter, publishStateInterval: 25000, publishVisualizationInterval: 0 },
      { initialPosition: { mapId: "hall", x: 0, y: n, theta: 0, lastNodeId: `v${n}-0` }, vehicleSpeed: 1, tickRate: 10 });
    await controller.start();
    controllers.push(controller);
  }
  console.log("open");
};
readline.createInterface({ input: process.stdin }).on("line", line => {
  if (line === "open") open().catch(error => { console.error(error); process.exit(1); });
  if (line === "log") console.log("logged");
}).on("close", () => process.exit(0));
