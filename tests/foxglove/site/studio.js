// Foxglove Studio on its own: settings and layouts live in memory, the recording comes by address (?ds=remote-file&ds.url=).
const settings = new Map([["telemetry.telemetryEnabled", false], ["telemetry.crashReportingEnabled", false], ["launchPreference", "web"]]);
const layouts = new Map();
const properties = {
  deepLinks: [location.href],
  appConfiguration: {
    get: (key) => settings.get(key),
    set: async (key, value) => void settings.set(key, value),
    addChangeListener: () => {},
    removeChangeListener: () => {},
  },
  layoutStorage: {
    list: async () => [...layouts.values()],
    get: async (_, id) => layouts.get(id),
    put: async (_, layout) => (layouts.set(layout.id, layout), layout),
    delete: async (_, id) => void layouts.delete(id),
    importLayouts: async () => {},
  },
  dataSources: [new McapLocalDataSourceFactory(), new RemoteDataSourceFactory()],
  extensionLoaders: [],
  enableGlobalCss: true,
};
initI18n().then(() => ReactDOM.render(React.createElement(App, properties), document.getElementById("root")));
