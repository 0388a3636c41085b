// German for the codes of the protocol, by their English words. A code that is missing here is shown in English.

export const codes: Readonly<Record<string, string>> = {
  // flight states
  idle: 'ruht', arming: 'schärft', 'taking off': 'startet', holding: 'hält', 'going to': 'fliegt hin', following: 'folgt', leading: 'führt',
  returning: 'kehrt zurück', landing: 'landet', 'pilot control': 'Pilot steuert', faulted: 'gestört',
  // modes
  unknown: 'unbekannt', manual: 'manuell', altitude: 'Höhe', position: 'Position', stabilized: 'stabilisiert', ready: 'bereit',
  'take off': 'Start', hold: 'Halten', mission: 'Mission', return: 'Rückkehr', land: 'Landung', descend: 'Sinken', termination: 'Abbruch',
  'in the air': 'in der Luft', 'on the ground': 'am Boden',
  // how old what is known is
  live: 'aktuell', delayed: 'verzögert', stale: 'veraltet', lost: 'verloren', connecting: 'verbindet', incompatible: 'passt nicht',
  // urgency
  info: 'Info', advisory: 'Hinweis', warning: 'Warnung', critical: 'kritisch',
  // life of a command
  sending: 'wird gesendet', sent: 'gesendet', executing: 'läuft', done: 'erledigt', refused: 'abgelehnt', replaced: 'ersetzt',
  // fixes
  none: 'keine', 'no fix': 'kein Fix', '2D fix': '2D-Fix', '3D fix': '3D-Fix', 'RTK fixed': 'RTK fest', 'RTK float': 'RTK gleitend',
  // states of actors and plugins
  running: 'läuft', restarting: 'startet neu', 'given up': 'aufgegeben', stopped: 'angehalten', starting: 'startet', failed: 'ausgefallen',
  // states of a video stream
  stalled: 'steht', 'no key picture': 'kein Schlüsselbild', 'no pictures': 'keine Bilder',
  // kinds of events
  adopted: 'übernommen', 'not adopted': 'nicht übernommen', 'link lost': 'Verbindung verloren', 'link regained': 'Verbindung wieder da',
  'autopilot rebooted': 'Autopilot neu gestartet', 'flight state': 'Flugzustand', command: 'Befehl', steer: 'steuern', failsafe: 'Failsafe',
  avoidance: 'Ausweichen', fences: 'Zäune', preflight: 'Vorflug', 'emergency stop': 'Nothalt', formation: 'Formation', trajectory: 'Bahn',
  supervision: 'Aufsicht', stream: 'Datenstrom', 'status text': 'Meldung des Autopiloten', connection: 'Verbindung', swarm: 'Verbund', control: 'Zuständigkeit', parameter: 'Parameter',
  // shapes and how they are kept
  line: 'Reihe', column: 'Kolonne', wedge: 'Keil', 'echelon left': 'Staffel links', 'echelon right': 'Staffel rechts', diamond: 'Raute', circle: 'Kreis', arc: 'Bogen', square: 'Quadrat', grid: 'Gitter',
  box: 'Quader', sphere: 'Kugel', helix: 'Schraube', free: 'Frei', slots: 'Plätzen', distances: 'Abständen', bearings: 'Peilungen',
  // a preflight item
  red: 'rot', amber: 'gelb', green: 'grün', 'in air': 'in der Luft',
  // how the reading of parameters ended, and what one is
  'it was stopped': 'angehalten', 'the link was lost': 'die Verbindung ging verloren', 'the autopilot does not answer': 'der Autopilot antwortet nicht',
  'a whole number': 'eine ganze Zahl', 'a real number': 'eine reelle Zahl',
  // what is checked before a flight, and the rest of what is named
  'operator not heard': 'Bediener nicht gehört', 'energy for the way home': 'Energie für den Heimweg', 'GNSS loss': 'GNSS-Ausfall',
  'GNSS disagreement': 'GNSS-Widerspruch',
  // what a track or a finding may be
  bird: 'Vogel', drone: 'Drohne', aeroplane: 'Flugzeug', airplane: 'Flugzeug', helicopter: 'Hubschrauber', person: 'Person', vehicle: 'Fahrzeug', boat: 'Boot',
  // kinds of payloads and what they do
  gimbal: 'Kardan', camera: 'Kamera', radio: 'Funk', detector: 'Detektor', model: 'Modell', picture: 'Bild', video: 'Video', survey: 'Vermessung', nobody: 'niemand', us: 'uns', angles: 'Winkel', rates: 'Drehraten', 'point at': 'zielt auf',
};
