-- A ledger as version 1 of the tables wrote it, with three defects of two parts. Never edited: old files stay readable.
PRAGMA application_id = 1146637383;
PRAGMA journal_mode = WAL;
CREATE TABLE schema_version (version INTEGER PRIMARY KEY, applied_us INTEGER NOT NULL);
CREATE TABLE part (
  id INTEGER PRIMARY KEY,
  type TEXT NOT NULL,
  serial TEXT NOT NULL,
  UNIQUE (type, serial));
CREATE TABLE defect (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  part INTEGER NOT NULL REFERENCES part (id),
  x_m REAL NOT NULL, y_m REAL NOT NULL, z_m REAL NOT NULL,
  normal_x REAL NOT NULL, normal_y REAL NOT NULL, normal_z REAL NOT NULL,
  zone TEXT NOT NULL,
  time_us INTEGER NOT NULL,
  session_us INTEGER NOT NULL,
  arm TEXT NOT NULL CHECK (arm IN ('left', 'right')),
  confidence REAL NOT NULL CHECK (confidence BETWEEN 0 AND 1),
  state TEXT NOT NULL CHECK (state IN ('open', 'confirmed', 'withdrawn')),
  source TEXT NOT NULL);
CREATE INDEX defect_by_part ON defect (part);
CREATE INDEX defect_by_time ON defect (time_us);
INSERT INTO schema_version VALUES (1, 1700000000000000);
INSERT INTO part VALUES (1, 'bumper-front-a', '0001'), (2, 'bumper-front-a', '0002');
INSERT INTO defect VALUES
  (1, 1, 0.25, 0.5, 0.125, 0.0, -1.0, 0.0, 'upper left', 1700000001000000, 33333, 'right', 0.75, 'open', 'live'),
  (2, 1, -0.25, 0.5, 0.125, 0.0, -1.0, 0.0, '', 1700000002000000, 66666, 'left', 0.5, 'confirmed', 'live'),
  (5, 2, 0.5, 0.5, 0.125, 1.0, 0.0, 0.0, 'lip', 1700000003000000, 99999, 'left', 1.0, 'withdrawn', 'live');
