// Starts Studio with one layout, the JSON file that the address names as `layout`, in the colours of its `theme` (dark or
// light), and nothing that would call home.
// The log is named by the address too (`ds=remote-file&ds.url=...`), as in a link that Studio itself would make.

const LAYOUT = "the-log-s-own";
const asked = new URLSearchParams(location.search);

function settings() {
  const values = new Map(
    Object.entries({
      colorScheme: asked.get("theme"),
      timezone: "UTC",
      showOpenDialogOnStartup: false,
      "telemetry.telemetryEnabled": false,
      "telemetry.crashReportingEnabled": false,
    }),
  );
  return {
    get: (key) => values.get(key),
    set: async (key, value) => void values.set(key, value),
    addChangeListener() {},
    removeChangeListener() {},
  };
}

function storage(data) {
  const baseline = { data, savedAt: new Date(0).toISOString() };
  const kept = new Map([[LAYOUT, { id: LAYOUT, name: LAYOUT, permission: "CREATOR_WRITE", baseline }]]);
  return {
    list: async () => Array.from(kept.values()),
    get: async (_namespace, id) => kept.get(id),
    put: async (_namespace, layout) => (kept.set(layout.id, layout), layout),
    delete: async (_namespace, id) => void kept.delete(id),
    importLayouts: async () => {},
    migrateUnnamespacedLayouts: async () => {},
  };
}

async function start() {
  const answer = await fetch(asked.get("layout"));
  const layoutStorage = storage(await answer.json());
  localStorage.setItem("studio.profile-data", JSON.stringify({ currentLayoutId: LAYOUT }));
  await window.initI18n();
  const app = React.createElement(window.App, {
    appConfiguration: settings(),
    dataSources: [new window.RemoteDataSourceFactory()],
    deepLinks: [location.href],
    enableGlobalCss: true,
    extensionLoaders: [],
    layoutStorage,
  });
  ReactDOM.render(app, document.getElementById("studio"));
}

start();
