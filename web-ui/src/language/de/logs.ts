// German for the logs that autopilots keep themselves.

export const logs = {
  Logs: 'Logs', 'Logs of vehicle {id}': 'Logs von Fahrzeug {id}', Number: 'Nummer', 'Last written': 'Zuletzt geschrieben', 'time not known': 'Zeit unbekannt', Fetch: 'Holen', 'Fetch log {number}': 'Log {number} holen',
  'This vehicle is flown over DDS, and its logs cannot be reached there. They can over MAVLink.': 'Dieses Fahrzeug wird über DDS geflogen; dort sind seine Logs nicht erreichbar. Über MAVLink sind sie es.',
  'The vehicle is armed. Logs are fetched on the ground only.': 'Das Fahrzeug ist scharf. Logs werden nur am Boden geholt.', 'The autopilot has no log.': 'Der Autopilot hat kein Log.',
  'The other logs are listed when this one is there.': 'Die anderen Logs werden aufgelistet, wenn dieses da ist.', 'PX4 writes these logs on its own card (ULog). A fetched log is kept on the node, beside the recording of its flight.':
    'PX4 schreibt diese Logs auf seine eigene Karte (ULog). Ein geholtes Log liegt auf dem Knoten, neben der Aufzeichnung seines Fluges.',
  '{received} of {size}': '{received} von {size}', 'Fetching log {number}': 'Log {number} wird geholt', 'Log {number} was fetched, {size}': 'Log {number} wurde geholt, {size}', 'Log {number} was not fetched: {why}': 'Log {number} wurde nicht geholt: {why}',
  'the vehicle is armed': 'das Fahrzeug ist scharf', 'the vehicle was armed': 'das Fahrzeug wurde geschärft', 'another log of it is being fetched': 'ein anderes Log von ihm wird gerade geholt',
  // beside the recording of a flight
  "Autopilots' logs": 'Logs der Autopiloten', '{vehicle}, log {number}': '{vehicle}, Log {number}',
} as const;
