// A fleet manager made of vda-5050-lib's MasterController, unmodified. It validates every message by the schemas of 2.0.
const { MasterController, BlockingType } = require("vda-5050-lib");
const say = value => console.log(JSON.stringify(value));
const agv = { manufacturer: "Woosh", serialNumber: "A-17" };
const places = { n1: [0, 0], n2: [1, -0.5], n3: [3, 1] };
const node = (id, sequenceId, released, actions = []) => ({
  nodeId: id, sequenceId, released, actions,
  nodePosition: { x: places[id][0], y: places[id][1], mapId: "hall", allowedDeviationXY: 0.3, allowedDeviationXy: 0.3 },
});
const edge = (from, to, sequenceId, released, actions = []) => ({
  edgeId: from + to, sequenceId, released, startNodeId: from, endNodeId: to, actions,
});
const action = (id, type, blocking = BlockingType.None) => ({ actionId: id, actionType: type, blockingType: blocking });
const fail = why => { say({ event: "failed", why: String(why) }); process.exit(1); };
process.on("unhandledRejection", fail);

const master = new MasterController(
  { interfaceName: "uagv", transport: { brokerUrl: process.env.BROKER, connectTimeout: 5000 }, vdaVersion: "2.0.0" }, {});

const order = (given, whileDriving = () => {}) => new Promise((done, broken) => master.assignOrder(agv, given, {
  onOrderProcessed: (withError, byCancelation, active, context) => {
    const told = { event: "order", orderId: given.orderId, update: context.order.orderUpdateId,
      error: withError ? withError.errorType : null, cancelled: byCancelation, active, last: context.state.lastNodeId };
    say(told);
    if (!active) done(told);
  },
  onNodeTraversed: (n, nextEdge, nextNode) => say({ event: "node", orderId: given.orderId, node: n.nodeId }),
  onEdgeTraversing: (e, start, end, changes, count) => whileDriving(e, count),
  onEdgeTraversed: e => say({ event: "edge", edge: e.edgeId }),
  onActionStateChanged: (state, error, a) => say({ event: "action", id: a.actionId, status: state.actionStatus }),
}).catch(broken));

const instant = (id, type) => new Promise((done, broken) => master.initiateInstantActions(agv, { instantActions: [action(id, type, BlockingType.Hard)] }, {
  onActionStateChanged: (state, error) => {
    say({ event: "instant", id, status: state.actionStatus, error: error ? error.errorType : null });
    if (["FINISHED", "FAILED"].includes(state.actionStatus)) done(state.actionStatus);
  },
  onActionError: error => { say({ event: "instant error", id, error: error.errorType }); done("FAILED"); },
}).catch(broken));

(async () => {
  await master.start();
  await new Promise(done => master.trackAgvs((id, state, at) => { say({ event: "agv", state }); if (state === "ONLINE") done(); }));
  await instant("state-1", "stateRequest");

  // An order with a horizon, whose update is sent when the vehicle is on its way.
  let sent = false;
  const first = order({
    orderId: "one", orderUpdateId: 0,
    nodes: [node("n1", 0, true, [action("one-a", "beep", BlockingType.Hard), action("one-b", "beep", BlockingType.Soft)]), node("n2", 2, true), node("n3", 4, false)],
    edges: [edge("n1", "n2", 1, true), edge("n2", "n3", 3, false)],
  }, e => {
    if (e.edgeId === "n1n2" && !sent) { sent = true; update(); }
  });
  let updated;
  const second = new Promise(done => { updated = done; });
  const update = () => order({
    orderId: "one", orderUpdateId: 1,
    nodes: [node("n2", 2, true), node("n3", 4, true, [action("one-c", "beep", BlockingType.Hard)])],
    edges: [edge("n2", "n3", 3, true, [action("one-e", "beep")])],
  }).then(updated, fail);
  await Promise.race([first, second]);
  await second;

  // Another, cancelled on its way.
  let asked = false;
  let cancel;
  const cancelled = new Promise(done => { cancel = done; });
  const third = order({
    orderId: "two", orderUpdateId: 0, nodes: [node("n3", 0, true), node("n1", 2, true, [action("two-never", "beep")])],
    edges: [edge("n3", "n1", 1, true)],
  }, () => { if (!asked) { asked = true; setTimeout(() => instant("cancel-1", "cancelOrder").then(cancel, fail), 400); } });
  await cancelled;
  await third;
  await instant("cancel-2", "cancelOrder");

  // One whose first node is far away, and one that it cannot do.
  await order({ orderId: "far", orderUpdateId: 0, nodes: [node("n2", 0, true)], edges: [] });
  await master.stop();
  process.exit(0);
})().catch(fail);
