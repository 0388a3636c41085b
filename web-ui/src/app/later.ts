// What of the console is not before the eyes when it is opened. It is fetched when it is wanted, or ahead of that as soon as the swarm is seen:
// over a thin link the vehicles come first, and later a link that is lost must not keep a panel away. Must never hold the map, the fleet, the
// commands or the emergency stop.

export const later = {
  fleetPage: () => import('../features/fleet/FleetPage.svelte'),
  vehiclePage: () => import('../features/fleet/VehiclePage.svelte'),
  parametersPage: () => import('../features/parameters/ParametersPage.svelte'),
  logsPage: () => import('../features/logs/LogsPage.svelte'),
  alertsPage: () => import('../features/alerts/AlertsPage.svelte'),
  flightsPage: () => import('../features/flights/FlightsPage.svelte'),
  replayControls: () => import('../features/replay/ReplayControls.svelte'),
  linksPage: () => import('../features/links/LinksPage.svelte'),
  videoPage: () => import('../features/video/VideoPage.svelte'),
  videoInset: () => import('../features/video/VideoInset.svelte'),
  plugins: () => import('../features/plugins/PluginList.svelte'),
  supervision: () => import('../features/supervision/SupervisionTree.svelte'),
  preflight: () => import('../features/preflight/PreflightPanel.svelte'),
  formation: () => import('../features/formation/FormationPanel.svelte'),
  events: () => import('../features/alerts/EventPanel.svelte'),
  route: () => import('../features/formation/RoutePanel.svelte'),
  hand: () => import('../features/byhand/HandPanel.svelte'),
  fences: () => import('../features/fences/FencePanel.svelte'),
  payloads: () => import('../features/payloads/PayloadPanel.svelte'),
  tracks: () => import('../features/observed/TrackPanel.svelte'),
  swarm: () => import('../features/swarm/SwarmPanel.svelte'),
  commands: () => import('../features/commands/CommandHistory.svelte'),
  layers: () => import('../features/map/LayerList.svelte'),
  goTo: () => import('../features/goto/GoToNote.svelte'),
  settings: () => import('./SettingsSheet.svelte'),
  shortcuts: () => import('./ShortcutList.svelte'),
};

/** Fetches all of it. What does not come is asked for again when it is opened, and says so there. */
export async function fetchAhead(): Promise<void> {
  await Promise.allSettled(Object.values(later).map((load) => load()));
}
